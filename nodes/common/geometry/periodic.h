// Points and cells of a periodic box.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"

namespace terrazzo {

// i modulo n: 0 … n − 1, also for i < 0.
inline int wrap_index(int i, int n) {
  i %= n;
  return i < 0 ? i + n : i;
}

// The same where every second period is a mirror image: 0 … n − 1, n − 1 … 0, and so on.
inline int mirror_index(int i, int n) {
  i = wrap_index(i, 2 * n);
  return i < n ? i : 2 * n - 1 - i;
}

// p, moved by whole edges of the box into [0, box).
inline Vec3 wrap_point(Vec3 p, const Vec3& box) {
  for (int a = 0; a < 3; ++a) {
    p[a] -= std::floor(p[a] / box[a]) * box[a];
    if (!(p[a] >= 0 && p[a] < box[a])) p[a] = 0;  // by rounding
  }
  return p;
}

// The difference of two points' nearest images, where `d` is that of the points themselves.
inline Vec3 nearest_image(Vec3 d, const Vec3& box) {
  for (int a = 0; a < 3; ++a) d[a] -= std::round(d[a] / box[a]) * box[a];
  return d;
}

// The cells of a grid that fills a periodic box, numbered with x fastest.
struct PeriodicCells {
  Vec3 box = Vec3::Zero();
  Vec3i cells = Vec3i::Zero();

  // Cells of about the edge `width`; 1 to `most` along each axis.
  PeriodicCells() = default;
  PeriodicCells(const Vec3& box, double width, int most) : box(box) {
    for (int a = 0; a < 3; ++a) cells[a] = std::clamp<int>(box[a] / width, 1, most);
  }
  std::size_t count() const { return index(0, 0, cells[2]); }
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * cells[1] + y) * cells[0] + x;
  }
  // The cell of a point in the box.
  std::size_t at(const Vec3& p) const {
    const auto along = [&](int a) { return std::clamp<int>(p[a] / box[a] * cells[a], 0, cells[a] - 1); };
    return index(along(0), along(1), along(2));
  }
  // Calls f(cell) for each cell that meets the cube of half edge `reach` around p, once, in a fixed order.
  template <class F>
  void visit(const Vec3& p, double reach, F&& f) const {
    Vec3i lo, hi;
    for (int a = 0; a < 3; ++a) {
      lo[a] = round_down((p[a] - reach) / box[a] * cells[a]);
      hi[a] = std::min(round_down((p[a] + reach) / box[a] * cells[a]), lo[a] + cells[a] - 1);
    }
    for (int z = lo[2]; z <= hi[2]; ++z)
      for (int y = lo[1]; y <= hi[1]; ++y) {
        const std::size_t row = index(0, wrap_index(y, cells[1]), wrap_index(z, cells[2]));
        for (int x = lo[0]; x <= hi[0]; ++x) f(row + static_cast<std::size_t>(wrap_index(x, cells[0])));
      }
  }
};

}  // namespace terrazzo
