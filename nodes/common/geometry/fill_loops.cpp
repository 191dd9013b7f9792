#include "nodes/common/geometry/fill_loops.h"

#include <algorithm>
#include <cmath>

namespace terrazzo {

void fill_loops(const std::vector<Loop>& loops, int width, int height,
                const std::function<void(int y, int begin, int end)>& row) {
  double low = INFINITY, high = -INFINITY;
  for (const Loop& loop : loops)
    for (const Vec2& p : loop) {
      low = std::min(low, p.y());
      high = std::max(high, p.y());
    }
  if (!(low < high)) return;
  // The first pixel whose center lies behind; 0 for NaN, which differences of huge numbers give.
  const auto first = [](double at, int most) {
    return at > 0.5 ? static_cast<int>(std::min(std::ceil(at - 0.5), static_cast<double>(most))) : 0;
  };
  const int top = first(low, height), bottom = first(high, height);
  std::vector<std::vector<int>> crossings(bottom - top);
  for (const Loop& loop : loops)
    for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
      const Vec2 &a = loop[j].y() < loop[i].y() ? loop[j] : loop[i],
                 &b = loop[j].y() < loop[i].y() ? loop[i] : loop[j];
      const int end = first(b.y(), height);
      for (int y = first(a.y(), height); y < end; ++y)
        crossings[y - top].push_back(
            first(a.x() + (y + 0.5 - a.y()) * (b.x() - a.x()) / (b.y() - a.y()), width));
    }
  for (int y = top; y < bottom; ++y) {
    std::vector<int>& x = crossings[y - top];
    std::sort(x.begin(), x.end());
    for (std::size_t k = 0; k + 1 < x.size(); k += 2)
      if (x[k] < x[k + 1]) row(y, x[k], x[k + 1]);
  }
}

}  // namespace terrazzo
