#include "nodes/packing/rigid/neighbors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"

namespace terrazzo::packing {
namespace {

struct Level {
  double largest = 0;  // radius
  PeriodicCells grid;
  std::vector<std::int32_t> begin;  // per cell, + 1
  std::vector<std::int32_t> item;
  std::vector<Vec3> place;  // positions of the items, for sequential access
};

std::vector<Level> make_levels(const Vec3& box, const std::vector<Vec3>& position,
                               const std::vector<double>& radius, const std::vector<int>& level_of, int count,
                               double reach) {
  std::vector<Level> levels(count);
  std::vector<std::size_t> members(count, 0);
  for (std::size_t i = 0; i < radius.size(); ++i) {
    auto& level = levels[level_of[i]];
    level.largest = std::max(level.largest, radius[i]);
    ++members[level_of[i]];
  }
  for (int l = 0; l < count; ++l) {
    Level& level = levels[l];
    if (members[l] == 0) continue;
    // At most a few cells per member: a level with one tiny ball needs no fine grid.
    const double width = std::max(2 * level.largest + reach, std::cbrt(box.prod() / (4.0 * members[l] + 8)));
    level.grid = PeriodicCells(box, width, std::numeric_limits<int>::max());
    level.begin.assign(level.grid.count() + 1, 0);
    level.item.resize(members[l]);
  }
  std::vector<std::size_t> cell(radius.size());
  for (std::size_t i = 0; i < radius.size(); ++i) {
    Level& level = levels[level_of[i]];
    cell[i] = level.grid.at(position[i]);
    ++level.begin[cell[i] + 1];
  }
  for (auto& level : levels)
    for (std::size_t c = 1; c < level.begin.size(); ++c) level.begin[c] += level.begin[c - 1];
  std::vector<std::vector<std::int32_t>> at(count);
  for (int l = 0; l < count; ++l) at[l] = levels[l].begin;
  for (std::size_t i = 0; i < radius.size(); ++i) levels[level_of[i]].item[at[level_of[i]][cell[i]]++] = i;
  for (auto& level : levels)
    for (std::int32_t i : level.item) level.place.push_back(position[i]);
  return levels;
}

// A cell along one axis, and the period that it lies in. Most cells are inside the box and need no division.
struct WrappedCell {
  int at = 0, image = 0;
  WrappedCell(int c, int n) {
    image = c >= 0 && c < n ? 0 : c >= 0 ? c / n : -((n - 1 - c) / n);
    at = c - image * n;
  }
};

// Calls use(cell, period) for all cells of a grid that reach closer to p than `far`.
template <class Use>
void each_cell_near(const Vec3& box, const Vec3i& cells, const Vec3& p, double far, Use&& use) {
  std::array<int, 3> lo, hi;
  for (int a = 0; a < 3; ++a) {
    const double width = box[a] / cells[a];
    lo[a] = round_down((p[a] - far) / width);
    hi[a] = round_down((p[a] + far) / width);
  }
  std::array<int, 3> image;
  for (int z = lo[2]; z <= hi[2]; ++z) {
    const WrappedCell cz(z, cells[2]);
    image[2] = cz.image;
    const std::size_t plane = static_cast<std::size_t>(cz.at) * cells[1];
    for (int y = lo[1]; y <= hi[1]; ++y) {
      const WrappedCell cy(y, cells[1]);
      image[1] = cy.image;
      const std::size_t row = (plane + cy.at) * cells[0];
      for (int x = lo[0]; x <= hi[0]; ++x) {
        const WrappedCell cx(x, cells[0]);
        image[0] = cx.image;
        use(row + cx.at, image);
      }
    }
  }
}

Pair pair_of(std::int32_t i, std::int32_t j, const std::array<int, 3>& image) {
  Pair pair{i,
            j,
            {static_cast<std::int8_t>(image[0]), static_cast<std::int8_t>(image[1]),
             static_cast<std::int8_t>(image[2])}};
  if (j < i) {
    std::swap(pair.a, pair.b);
    for (auto& v : pair.image) v = -v;
  }
  return pair;
}

}  // namespace

std::vector<Pair> near_pairs(const Vec3& box, const std::vector<Vec3>& position,
                             const std::vector<double>& radius, double reach, const Work& work) {
  const std::size_t n = position.size();
  if (n < 2) return {};
  const double largest = *std::max_element(radius.begin(), radius.end());
  std::vector<int> level_of(n);
  int count = 1;
  for (std::size_t i = 0; i < n; ++i) {
    level_of[i] = radius[i] > 0 ? std::min(12, round_down(std::log2(largest / radius[i]) + 1e-9)) : 12;
    count = std::max(count, level_of[i] + 1);
  }
  const auto levels = make_levels(box, position, radius, level_of, count, reach);

  constexpr std::size_t kGrain = 512;
  std::vector<std::vector<Pair>> parts((n + kGrain - 1) / kGrain);
  work.parallel(n, kGrain, [&](std::size_t begin, std::size_t end) {
    auto& out = parts[begin / kGrain];
    for (std::size_t s = begin; s < end; ++s) {
      const std::int32_t i = s;
      const Vec3& p = position[i];
      for (int l = level_of[i]; l >= 0; --l) {
        const Level& level = levels[l];
        if (level.item.empty()) continue;
        const double far = radius[i] + level.largest + reach;
        each_cell_near(box, level.grid.cells, p, far, [&](std::size_t f, const std::array<int, 3>& image) {
          const Vec3 from = p - Vec3(image[0] * box[0], image[1] * box[1], image[2] * box[2]);
          for (std::int32_t k = level.begin[f]; k < level.begin[f + 1]; ++k) {
            const double square = (level.place[k] - from).squaredNorm();
            if (square >= far * far) continue;
            const std::int32_t j = level.item[k];
            if (l == level_of[i] && j <= i) continue;
            const double sum = radius[i] + radius[j] + reach;
            if (square >= sum * sum) continue;
            out.push_back(pair_of(i, j, image));
          }
        });
      }
    }
  });
  std::vector<Pair> pairs;
  std::size_t total = 0;
  for (const auto& part : parts) total += part.size();
  pairs.reserve(total);
  for (const auto& part : parts) pairs.insert(pairs.end(), part.begin(), part.end());
  return pairs;
}

Incidence incidence_of(std::size_t n, const std::vector<Pair>& pairs) {
  Incidence inc;
  inc.begin.assign(n + 1, 0);
  for (const auto& p : pairs) {
    ++inc.begin[p.a + 1];
    ++inc.begin[p.b + 1];
  }
  for (std::size_t i = 0; i < n; ++i) inc.begin[i + 1] += inc.begin[i];
  inc.entry.resize(2 * pairs.size());
  std::vector<std::int32_t> at(inc.begin.begin(), inc.begin.end() - 1);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    inc.entry[at[pairs[k].a]++] = 2 * k;
    inc.entry[at[pairs[k].b]++] = 2 * k + 1;
  }
  return inc;
}

}  // namespace terrazzo::packing
