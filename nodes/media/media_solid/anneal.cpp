#include "nodes/media/media_solid/anneal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/data/indices.h"
#include "nodes/media/media_solid/level.h"
#include "runtime/random.h"

namespace terrazzo::media_solid {
namespace {
using media::PhaseMap;

constexpr int kReach = 8;         // spacings go up to this fraction of the shortest side
constexpr int kWidest = 4;        // spacing at one level: coarser levels match longer ones
constexpr int kLeastVoxels = 6;   // along the shortest edge of the coarsest level
constexpr double kFewPlaces = 8;  // a frequency is known to that many places of the picture
// A temperature of 1 accepts what a random solid with these frequencies would show.
constexpr double kCoarseHeat = 10, kFineHeat = 5;
constexpr double kCooled = 0.8;     // share of the sweeps after which the temperature is 0
constexpr double kSettled = 2e-4;   // share of changed voxels at which sweeps end
constexpr int kRounds = 3;          // how often a level is heated at most
constexpr double kMatched = 0.002;  // mismatch of a table: frequencies are right within about 4 %
constexpr double kGain = 0.9;       // of the mismatch that a round must reach for another to follow

int shortest_side(const std::vector<PhaseMap>& pictures) {
  int side = 1 << 30;
  for (const PhaseMap& p : pictures) side = std::min({side, p.width, p.height});
  return side;
}

Vec3i size_at(const Vec3i& size, int stride) {
  return size.unaryExpr([&](int n) { return std::max(1, (n + stride / 2) / stride); });
}

// From coarse to fine.
std::vector<int> strides_of(const Vec3i& size, int side) {
  std::vector<int> out = {1};
  while (2 * out.front() <= side / kReach && size_at(size, 2 * out.front()).minCoeff() >= kLeastVoxels)
    out.insert(out.begin(), 2 * out.front());
  return out;
}

// A coarse voxel represents one of its voxels, not their mean, so its patterns are the pictures' own at
// larger spacings.
class Targets {
 public:
  Targets(const std::vector<PhaseMap>& pictures, const AnnealOptions& options)
      : pictures_(pictures), options_(options) {}
  std::vector<PatternTarget> at(int stride, const Vec3i& size) {
    std::vector<PatternTarget> out;
    for (int spacing = 1;
         spacing <= kWidest && spacing * stride <= std::max(1, shortest_side(pictures_) / kReach) &&
         (spacing == 1 || 4 * spacing <= size.minCoeff());
         spacing *= 2)
      for (int axis = 0; axis < 3; ++axis)
        if (const int p = options_.plane[axis]; p >= 0)
          out.push_back({axis, spacing, frequencies(p, spacing * stride)});
    return out;
  }

 private:
  const std::vector<Frequencies>& frequencies(int picture, int spacing) {
    auto& known = known_[{picture, spacing}];
    if (known.empty())
      for (int phase = 0; phase < pictures_[picture].phases; ++phase)
        known.push_back(pattern_frequencies(pictures_[picture], phase, spacing, options_.turned));
    return known;
  }

  const std::vector<PhaseMap>& pictures_;
  const AnnealOptions& options_;
  std::map<std::pair<int, int>, std::vector<Frequencies>> known_;
};

// Mean over the constrained planes.
std::vector<double> mean_fractions(const std::vector<PhaseMap>& pictures, const AnnealOptions& options) {
  std::vector<double> out(pictures[0].phases, 0);
  double planes = 0;
  for (const int p : options.plane)
    if (p >= 0) {
      const auto f = fractions_of(pictures[p]);
      for (std::size_t k = 0; k < f.size(); ++k) out[k] += f[k];
      ++planes;
    }
  for (double& f : out) f /= planes;
  return out;
}

std::vector<std::uint8_t> noise(std::size_t voxels, const std::vector<double>& fractions,
                                std::uint64_t seed) {
  std::vector<std::uint8_t> out(voxels);
  for (std::size_t i = 0; i < voxels; ++i) {
    double u = Random(seed, 3, i).uniform();
    std::uint8_t p = 0;
    while (p + 1u < fractions.size() && u >= fractions[p]) u -= fractions[p++];
    out[i] = p;
  }
  return out;
}

std::vector<std::uint8_t> enlarge(const std::vector<std::uint8_t>& coarse, const Vec3i& from,
                                  const Vec3i& to) {
  std::vector<std::uint8_t> out(voxels_in(to));
  std::size_t i = 0;
  for (int z = 0; z < to.z(); ++z)
    for (int y = 0; y < to.y(); ++y)
      for (int x = 0; x < to.x(); ++x, ++i) {
        const auto at = [&](int v, int a) { return static_cast<std::size_t>(v) * from[a] / to[a]; };
        out[i] = coarse[(at(z, 2) * from.y() + at(y, 1)) * from.x() + at(x, 0)];
      }
  return out;
}

// Whole numbers of voxels, with the remainder where it is largest.
std::vector<std::int64_t> counts_of(const std::vector<double>& fractions, std::int64_t voxels) {
  std::vector<std::int64_t> out;
  std::int64_t left = voxels;
  for (const double f : fractions) {
    out.push_back(static_cast<std::int64_t>(f * voxels));
    left -= out.back();
  }
  std::vector<std::size_t> order(out.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return fractions[a] * voxels - out[a] > fractions[b] * voxels - out[b];
  });
  for (std::size_t k = 0; left > 0; ++k, --left) ++out[order[k % order.size()]];
  return out;
}

// Coarse levels decide on the structure and are cheap.
int sweeps_at(int stride) { return stride == 1 ? 12 : stride == 2 ? 30 : 60; }

// Lowers the temperature from `heat` to 0. Returns the number of sweeps.
int cool(Level& level, int sweeps, double heat, std::size_t voxels, std::uint64_t seed, const Work& work) {
  for (int s = 0; s < sweeps; ++s) {
    const double temperature = heat * std::max(0.0, 1 - s / (kCooled * sweeps));
    const Work part = work.part(static_cast<double>(s) / sweeps, (s + 1.0) / sweeps);
    const std::size_t changes = level.sweep(seed + s, temperature, part);
    if (temperature == 0 && changes <= kSettled * voxels) return s + 1;
  }
  return sweeps;
}

// Thin walls need slower cooling than grains to close: coarse levels are heated again, for twice as many
// sweeps, until their patterns match or no longer gain from it. The finest level keeps their structure.
AnnealedLevel anneal(Level& level, int stride, std::size_t voxels, std::uint64_t seed, const Work& work) {
  const double heat = stride > 1 ? kCoarseHeat : kFineHeat;
  const int rounds = stride > 1 ? kRounds : 1;
  AnnealedLevel out{stride, 0, level.mismatch(), 0};
  double before = 0;
  for (int round = 0; round < rounds; ++round) {
    const double all = (1 << rounds) - 1;
    const Work part = work.part(((1 << round) - 1) / all, ((2 << round) - 1) / all);
    out.sweeps +=
        cool(level, sweeps_at(stride) << round, heat, voxels, mix64(seed * 4096 + stride) + out.sweeps, part);
    out.end = level.mismatch();
    if (out.end < kMatched * level.tables() || (round > 0 && out.end > kGain * before)) break;
    before = out.end;
  }
  return out;
}

}  // namespace

Solid synthesize(const std::vector<PhaseMap>& pictures, const AnnealOptions& options, const Work& work) {
  const int phases = pictures[0].phases;
  const auto fractions = mean_fractions(pictures, options);
  double pixels = 1e300;  // observed
  for (const PhaseMap& p : pictures)
    pixels = std::min(
        pixels, static_cast<double>(p.at.size() - std::count(p.at.begin(), p.at.end(), media::kUnobserved)));
  Targets targets(pictures, options);
  Solid out;
  Vec3i size = Vec3i::Zero();
  double done = 0;
  const auto strides = strides_of(options.size, shortest_side(pictures));
  for (const int stride : strides) {
    const Vec3i finer = size_at(options.size, stride);
    out.phase =
        size.isZero() ? noise(voxels_in(finer), fractions, options.seed) : enlarge(out.phase, size, finer);
    size = finer;
    // In proportion to the voxels that are visited at this level and at all, as if one more round helps.
    const auto visits = [&](int level) {
      return sweeps_at(level) * (level > 1 ? 3 : 1) / std::pow(level, 3.0);
    };
    double until = 0, all = 0;
    for (const int level : strides) {
      all += visits(level);
      if (level >= stride) until += visits(level);
    }
    until /= all;
    const Work part = work.part(done, until);
    done = until;
    part.progress(0, fmt::format("{} × {} × {} voxels", size.x(), size.y(), size.z()));
    Level level(std::move(out.phase), size, phases, targets.at(stride, size), kFewPlaces / pixels, part);
    out.levels.push_back(anneal(level, stride, voxels_in(size), options.seed, part));
    if (stride == 1) {
      level.settle(counts_of(fractions, static_cast<std::int64_t>(voxels_in(size))), part.quiet());
      out.levels.back().end = level.mismatch();
    }
    out.phase = level.take();
  }
  return out;
}

double memory_forecast(const Vec3i& size) {
  // The phases, their coarser copy and bits, the list of voxels at interfaces, which is copied once, and the
  // grids.
  return 30.0 * static_cast<double>(voxels_in(size)) + 64e6;
}

}  // namespace terrazzo::media_solid
