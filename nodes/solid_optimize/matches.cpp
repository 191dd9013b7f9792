#include "nodes/solid_optimize/matches.h"

#include <algorithm>
#include <cmath>

#include "runtime/random.h"

namespace terrazzo::solid_optimize {
namespace {

constexpr int kBlock = 6;  // patches

MatchFamily family_of(const Vec3i& size, int axis, int exemplar) {
  MatchFamily f;
  f.axis = axis, f.exemplar = exemplar;
  f.slices = size[axis];
  f.width = size[kSliceColumns[static_cast<std::size_t>(axis)]],
  f.height = size[kSliceRows[static_cast<std::size_t>(axis)]];
  f.columns = (f.width + 1) / 2, f.rows = (f.height + 1) / 2;
  f.at.resize(static_cast<std::size_t>(f.slices) * static_cast<std::size_t>(f.columns) *
              static_cast<std::size_t>(f.rows));
  f.weight.assign(f.at.size(), 1.0f);
  return f;
}

}  // namespace

MatchFamily random_matches(const Vec3i& size, int axis, int exemplar, const ExemplarLevel& e,
                           std::uint64_t seed) {
  MatchFamily f = family_of(size, axis, exemplar);
  for (std::size_t i = 0; i < f.at.size(); ++i)
    f.at[i] = e.starts[Random(seed, 0x50 + static_cast<std::uint64_t>(axis), i).below(e.starts.size())];
  return f;
}

MatchFamily carry_up(const MatchFamily& old, const Vec3i& from, const Vec3i& to, const ExemplarLevel& coarse,
                     const ExemplarLevel& fine, std::uint64_t seed, const Work& work) {
  MatchFamily f = family_of(to, old.axis, old.exemplar);
  const double in_x = static_cast<double>(fine.width) / coarse.width,
               in_y = static_cast<double>(fine.height) / coarse.height;
  const double by_slice = static_cast<double>(from[f.axis]) / to[f.axis];
  const double by_x = static_cast<double>(old.width) / f.width,
               by_y = static_cast<double>(old.height) / f.height;
  // A patch of the old level whose centre is nearest, and by how much it misses.
  const auto nearest = [](int start, double by, int patches, double& miss) {
    const double wanted = (start + kPatch / 2.0) * by - kPatch / 2.0;
    const int i = static_cast<int>(std::floor(wanted / 2 + 0.5));
    miss = wanted - 2 * i;
    return (i % patches + patches) % patches;
  };
  const auto place = [](double start, double miss, double scale, int size) {
    const double p = (start + miss + kPatch / 2.0) * scale - kPatch / 2.0;
    return std::clamp(static_cast<int>(std::floor(p + 0.5)), 0, size - kPatch);
  };
  work.parallel(static_cast<std::size_t>(f.slices), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      const auto from_slice = [&](double at) {
        return (static_cast<int>(std::floor(at * by_slice)) + old.slices) % old.slices;
      };
      const int slices[2] = {from_slice(static_cast<double>(s)), from_slice(static_cast<double>(s) + 1)};
      for (int j = 0; j < f.rows; ++j)
        for (int i = 0; i < f.columns; ++i) {
          // In half of all blocks slices 2k and 2k + 1 come from one, in the other half 2k − 1 and 2k: always
          // the same pairs would stay more alike than others, and the wrap is never within a pair.
          const auto block = static_cast<std::uint64_t>((j / kBlock) * f.columns + i / kBlock);
          const int slice = slices[Random(seed, 0x70 + static_cast<std::uint64_t>(f.axis), block).below(2)];
          double miss_x, miss_y;
          const int oi = nearest(2 * i, by_x, old.columns, miss_x),
                    oj = nearest(2 * j, by_y, old.rows, miss_y);
          const std::size_t o = (static_cast<std::size_t>(slice) * old.rows + oj) * old.columns + oi;
          const std::size_t n = (s * f.rows + j) * f.columns + i;
          const int x = place(old.at[o] % coarse.width, miss_x, in_x, fine.width),
                    y = place(old.at[o] / coarse.width, miss_y, in_y, fine.height);
          f.at[n] = static_cast<std::uint32_t>(y * fine.width + x);
          // A mask may be finer than the coarse level knew.
          if (!fine.usable[f.at[n]])
            f.at[n] = fine.starts[Random(seed, 0x60 + static_cast<std::uint64_t>(f.axis), n)
                                      .below(fine.starts.size())];
          f.weight[n] = old.weight[o];
        }
    }
  });
  return f;
}

double weigh(MatchFamily& f, double exponent, const Work& work) {
  const std::size_t n = f.weight.size();
  const double sum = work.reduce<double>(
      n, 1 << 15, 0.0,
      [&](std::size_t b, std::size_t e) {
        double s = 0;
        for (std::size_t i = b; i < e; ++i) s += f.weight[i];
        return s;
      },
      [](double a, double b) { return a + b; });
  const float floor = static_cast<float>(std::max(sum / static_cast<double>(n), 1e-12));
  const float power = static_cast<float>((exponent - 2) / 2);
  // Relative to the floor, so that weights stay near 1.
  work.parallel(n, 1 << 14, [&](std::size_t b, std::size_t e) {
    for (std::size_t i = b; i < e; ++i) f.weight[i] = std::pow(f.weight[i] / floor + 1.0f, power);
  });
  return floor;
}

}  // namespace terrazzo::solid_optimize
