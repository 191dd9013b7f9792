#include "nodes/solids/synthesis/matching/matches.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/matching/torus_box.h"
#include "runtime/random.h"

namespace terrazzo::solids {
namespace {

constexpr int kBlock = 6;  // patches

NeighborField family_of(const Vec3i& size, int axis, int exemplar) {
  NeighborField f;
  f.axis = axis;
  f.exemplar = exemplar;
  f.slices = size[axis];
  f.width = size[kSliceColumns[axis]];
  f.height = size[kSliceRows[axis]];
  f.columns = (f.width + 1) / 2;
  f.rows = (f.height + 1) / 2;
  f.at.resize(static_cast<std::size_t>(f.slices) * static_cast<std::size_t>(f.columns) * f.rows);
  f.weight.assign(f.at.size(), 1.0f);
  return f;
}

}  // namespace

NeighborField random_matches(const Vec3i& size, int axis, int exemplar, const ExemplarLevel& e,
                             std::uint64_t seed) {
  NeighborField f = family_of(size, axis, exemplar);
  for (std::size_t i = 0; i < f.at.size(); ++i)
    f.at[i] = e.starts[Random(seed, 0x50 + static_cast<std::uint64_t>(axis), i).below(e.starts.size())];
  return f;
}

int patch_below(int start, int period, int below, double& miss) {
  const int place = wrapped(start, period);
  const double by = static_cast<double>(below) / period;
  const double wanted = (place + kPatch / 2.0) * by - kPatch / 2.0;
  const int i = round_down(wanted / 2 + 0.5);
  miss = wanted - 2 * i;
  return i + floor_divide(start, period) * patches_around(below);
}

std::array<int, 2> slices_below(int slice, int period, int below) {
  const int place = wrapped(slice, period), turn = floor_divide(slice, period) * below;
  const double by = static_cast<double>(below) / period;
  return {round_down(place * by) + turn, round_down((place + 1.0) * by) + turn};
}

void carry_matches(const NeighborField& old, const CarriedPatches& columns, const CarriedPatches& rows,
                   const std::vector<std::array<int, 2>>& slices, const std::vector<int>& number,
                   const ExemplarLevel& coarse, const ExemplarLevel& fine, std::uint64_t seed,
                   NeighborField& f, const Work& work) {
  const double in_x = static_cast<double>(fine.width) / coarse.width,
               in_y = static_cast<double>(fine.height) / coarse.height;
  const auto place = [](double start, double miss, double scale, int size) {
    const double p = (start + miss + kPatch / 2.0) * scale - kPatch / 2.0;
    return std::clamp(round_down(p + 0.5), 0, size - kPatch);
  };
  work.parallel(f.slices, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s)
      for (std::size_t j = 0; j < rows.number.size(); ++j)
        for (std::size_t i = 0; i < columns.number.size(); ++i) {
          // In half of all blocks slices 2k and 2k + 1 come from one slice below, in the other half 2k − 1
          // and 2k. If the pairs were always the same, they would stay more alike than others, and the wrap
          // would never fall within a pair.
          const std::uint64_t block = (rows.number[j] / kBlock) * columns.around + columns.number[i] / kBlock;
          const int slice =
              slices[s][Random(seed, 0x70 + static_cast<std::uint64_t>(f.axis), block).below(2)];
          const std::size_t o =
              (static_cast<std::size_t>(slice) * old.rows + rows.from[j]) * old.columns + columns.from[i];
          const std::size_t n = (s * rows.number.size() + j) * columns.number.size() + i;
          const int x = place(old.at[o] % coarse.width, columns.miss[i], in_x, fine.width),
                    y = place(old.at[o] / coarse.width, rows.miss[j], in_y, fine.height);
          f.at[n] = y * fine.width + x;
          // A mask may exclude more at this level than it did at the coarse one.
          if (!fine.usable[f.at[n]]) {
            const auto item =
                (static_cast<std::uint64_t>(number[s]) * rows.around + rows.number[j]) * columns.around +
                columns.number[i];
            f.at[n] = fine.starts[Random(seed, 0x60 + static_cast<std::uint64_t>(f.axis), item)
                                      .below(fine.starts.size())];
          }
          f.weight[n] = old.weight[o];
        }
  });
}

NeighborField carry_up(const NeighborField& old, const Vec3i& from, const Vec3i& to,
                       const ExemplarLevel& coarse, const ExemplarLevel& fine, std::uint64_t seed,
                       const Work& work) {
  NeighborField f = family_of(to, old.axis, old.exemplar);
  const auto carried = [](int patches, int period, int below) {
    CarriedPatches c;
    c.around = patches;
    c.miss.resize(patches);
    for (int i = 0; i < patches; ++i) {
      c.number.push_back(i);
      c.from.push_back(wrapped(patch_below(2 * i, period, below, c.miss[i]), patches_around(below)));
    }
    return c;
  };
  std::vector<std::array<int, 2>> slices;
  std::vector<int> number;
  for (int s = 0; s < f.slices; ++s) {
    slices.push_back(slices_below(s, to[f.axis], from[f.axis]));
    for (int& k : slices.back()) k = wrapped(k, from[f.axis]);
    number.push_back(s);
  }
  carry_matches(old, carried(f.columns, f.width, old.width), carried(f.rows, f.height, old.height), slices,
                number, coarse, fine, seed, f, work);
  return f;
}

double weigh(NeighborField& f, double exponent, const Work& work) {
  const std::size_t n = f.weight.size();
  const double sum = work.reduce<double>(
      n, 1 << 15, 0.0,
      [&](std::size_t b, std::size_t e) {
        double s = 0;
        for (std::size_t i = b; i < e; ++i) s += f.weight[i];
        return s;
      },
      [](double a, double b) { return a + b; });
  const float floor = std::max(sum / static_cast<double>(n), 1e-12);
  const float power = (exponent - 2) / 2;
  // Relative to the floor, so that weights stay near 1.
  work.parallel(n, 1 << 14, [&](std::size_t b, std::size_t e) {
    for (std::size_t i = b; i < e; ++i) f.weight[i] = std::pow(f.weight[i] / floor + 1.0f, power);
  });
  return floor;
}

}  // namespace terrazzo::solids
