#include "nodes/media/annealing/descent.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::annealing {
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
AnnealedLevel heat_and_cool(Level& level, int stride, std::size_t voxels, std::uint64_t seed,
                            const Work& work) {
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

double visits(int stride) { return sweeps_at(stride) * (stride > 1 ? 3 : 1) / std::pow(stride, 3.0); }

Descent::Descent(const std::vector<PhaseMap>& pictures, const AnnealOptions& options)
    : pictures_(pictures), options_(options), strides_{1}, fractions_(mean_fractions(pictures, options)) {
  const int side = shortest_side(pictures);
  while (2 * strides_.front() <= side / kReach && size_at(2 * strides_.front()).minCoeff() >= kLeastVoxels)
    strides_.insert(strides_.begin(), 2 * strides_.front());
  pixels_ = 1e300;
  for (const PhaseMap& p : pictures)
    pixels_ = std::min(
        pixels_, static_cast<double>(p.at.size() - std::count(p.at.begin(), p.at.end(), media::kUnobserved)));
}

Vec3i size_at(const Vec3i& size, int stride) {
  return size.unaryExpr([&](int n) { return std::max(1, (n + stride / 2) / stride); });
}

Slab Descent::noise(int stride) const {
  Slab out{0, size_at(stride), {}};
  out.phase.resize(voxels_in(out.size));
  for (std::size_t i = 0; i < out.phase.size(); ++i) {
    double u = Random(options_.seed, 3, i).uniform();
    std::uint8_t p = 0;
    while (p + 1u < fractions_.size() && u >= fractions_[p]) u -= fractions_[p++];
    out.phase[i] = p;
  }
  return out;
}

Slab Descent::enlarge(const Slab& coarse, int coarse_stride, int stride, const Layers& layers) const {
  const Vec3i from = size_at(coarse_stride), to = size_at(stride);
  Slab out{layers.first, {to.x(), to.y(), layers.count}, {}};
  out.phase.reserve(voxels_in(out.size));
  const auto scaled = [&](std::int64_t v, int a) { return static_cast<int>(v * from[a] / to[a]); };
  for (int z = 0; z < layers.count; ++z) {
    const int turn = (layers.first + z) < 0 ? 1 : 0;  // the solid tiles
    const int layer = scaled(layers.first + z + turn * to.z(), 2) - turn * from.z() - coarse.first;
    const int at_z = (layer + from.z()) % from.z();
    for (int y = 0; y < to.y(); ++y)
      for (int x = 0; x < to.x(); ++x)
        out.phase.push_back(coarse.phase[voxel_at(scaled(x, 0), scaled(y, 1), at_z, coarse.size)]);
  }
  return out;
}

// A coarse voxel represents one of its voxels, not their mean, so its patterns are the pictures' own at
// larger spacings.
std::vector<PatternTarget> Descent::targets(int stride, const Vec3i& size) {
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

const std::vector<Frequencies>& Descent::frequencies(int picture, int spacing) {
  auto& known = known_[{picture, spacing}];
  if (known.empty())
    for (int phase = 0; phase < pictures_[picture].phases; ++phase)
      known.push_back(pattern_frequencies(pictures_[picture], phase, spacing, options_.turned));
  return known;
}

AnnealedLevel Descent::anneal(Slab& slab, int stride, Ends ends, std::uint64_t seed,
                              const std::vector<std::int64_t>& count, const Work& work) {
  Level level(std::move(slab.phase), slab.size, pictures_[0].phases, targets(stride, slab.size),
              kFewPlaces / pixels_, ends, work);
  AnnealedLevel out = heat_and_cool(level, stride, voxels_in(slab.size), seed, work);
  if (!count.empty()) {
    level.settle(count, work.quiet());
    out.end = level.mismatch();
  }
  slab.phase = level.take();
  return out;
}

// With the remainder where it is largest.
std::vector<std::int64_t> Descent::counts(std::int64_t voxels) const {
  std::vector<std::int64_t> out;
  std::int64_t left = voxels;
  for (const double f : fractions_) {
    out.push_back(static_cast<std::int64_t>(f * voxels));
    left -= out.back();
  }
  std::vector<std::size_t> order(out.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return fractions_[a] * voxels - out[a] > fractions_[b] * voxels - out[b];
  });
  for (std::size_t k = 0; left > 0; ++k, --left) ++out[order[k % order.size()]];
  return out;
}

}  // namespace terrazzo::annealing
