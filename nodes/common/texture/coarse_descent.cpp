#include "nodes/common/texture/coarse_descent.h"

#include <algorithm>

#include "runtime/random.h"

namespace terrazzo {
namespace {

constexpr int kLongAs = 4;    // minimum ratio of field length to offset reach
constexpr int kEachPair = 4;  // minimum number of pixel pairs per pair of levels
constexpr int kMostOctaves = 10;

struct Resolution {
  int stride;
  Vec3i size;
  std::vector<PairTarget> targets;
};

Vec3i coarser(const Vec3i& size, int stride) {
  return ((size.array() + stride / 2) / stride).max(1).matrix();
}

// Axes of one pixel, as in an image, do not count.
bool long_enough(const Vec3i& full, const Vec3i& size, int reach) {
  for (int a = 0; a < 3; ++a)
    if (full[a] > 1 && size[a] <= kLongAs * reach) return false;
  return true;
}

std::vector<Resolution> resolutions(const Vec3i& size, const PairTargets& targets, const DescentOptions& s) {
  std::vector<Resolution> out;
  out.push_back({1, size, targets(1, size)});
  for (int k = 1; k <= kMostOctaves && s.start == Start::Coarse; ++k) {
    Resolution next{1 << k, coarser(size, 1 << k), {}};
    if (!long_enough(size, next.size, s.reach)) break;
    next.targets = targets(next.stride, next.size);
    if (next.targets.empty()) break;
    out.push_back(std::move(next));
  }
  std::reverse(out.begin(), out.end());
  return out;
}

// A pixel between two coarse ones copies either of them at random. Copying blocks would leave steps at their
// edges that the sweeps cannot remove.
LevelField enlarged(const LevelField& from, const Vec3i& size, bool periodic, std::uint64_t seed) {
  LevelField out(size);
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        const std::size_t i = out.index(x, y, z);
        Random random(seed, 0x0cc1, i);
        const Vec3i here(x, y, z);
        Vec3i at;
        for (int a = 0; a < 3; ++a) {
          const std::int64_t scaled = static_cast<std::int64_t>(here[a]) * from.size[a];
          at[a] = scaled / size[a];
          const std::uint64_t over = scaled % size[a];
          if (over == 0 || random.below(size[a]) >= over) continue;
          at[a] = at[a] + 1 < from.size[a] ? at[a] + 1 : periodic ? 0 : at[a];
        }
        out.at[i] = from.at[from.index(at.x(), at.y(), at.z())];
      }
  return out;
}

}  // namespace

std::optional<Cooccurrence> measure_apart(const std::vector<LevelField>& sections, int levels,
                                          const std::vector<Vec3i>& offsets, int stride, const Work& work) {
  std::vector<Vec3i> apart;
  for (const Vec3i& o : offsets) apart.push_back(stride * o);
  Cooccurrence c = measure_cooccurrence(sections, levels, apart, work);
  const std::int64_t least = static_cast<std::int64_t>(kEachPair) * levels * levels;
  for (const std::int64_t pairs : c.pairs)
    if (stride > 1 && pairs < least) return std::nullopt;
  return c;
}

DescentResult descend(const std::vector<const LevelField*>& source, const Vec3i& size,
                      const PairTargets& targets, const DescentOptions& s, const Work& work) {
  const auto all = resolutions(size, targets, s);
  double pixels = 0, done = 0;
  for (const auto& r : all) pixels += r.size.cast<double>().prod();
  DescentResult out;
  for (const Resolution& r : all) {
    LevelField start = &r == &all.front() ? level_noise(source, s.levels, r.size, s.seed)
                                          : enlarged(out.field, r.size, s.periodic, s.seed + r.stride);
    LevelDescent descent(start, s.levels, s.periodic, r.targets);
    out.sweeps.push_back({r.stride, 0, descent.error(), 0});
    if (r.stride == 1)
      out.noise_error = all.size() == 1 ? descent.error()
                                        : LevelDescent(level_noise(source, s.levels, size, s.seed), s.levels,
                                                       s.periodic, r.targets)
                                              .error();
    const double share = r.size.cast<double>().prod() / pixels;
    for (int k = 0; k < s.sweeps; ++k) {
      const Work part = work.part(done + share * k / s.sweeps, done + share * (k + 1) / s.sweeps);
      const std::uint64_t order = mix64(s.seed) + k + 1000003 * static_cast<std::uint64_t>(r.stride - 1);
      const std::size_t changed = descent.sweep(order, part);
      out.sweeps.push_back({r.stride, k + 1, descent.error(), changed});
      if (changed == 0) break;
    }
    done += share;
    out.field = descent.field();
  }
  return out;
}

Table descent_table(const std::vector<DescentSweep>& sweeps) {
  Table out;
  out.columns = {"stride", "sweep", "error", "changed"};
  for (const DescentSweep& s : sweeps)
    out.rows.push_back({static_cast<double>(s.stride), static_cast<double>(s.sweep), s.error,
                        static_cast<double>(s.changed)});
  return out;
}

}  // namespace terrazzo
