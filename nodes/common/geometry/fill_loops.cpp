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
  // Pixel i is crossed if its center i + ½ is.
  const auto first = [](double at, int most) {
    return static_cast<int>(std::clamp(std::ceil(at - 0.5), 0.0, static_cast<double>(most)));
  };
  const int top = first(low, height), bottom = first(high, height);
  std::vector<std::vector<double>> crossings(bottom - top);
  for (const Loop& loop : loops)
    for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
      const Vec2 &a = loop[j].y() < loop[i].y() ? loop[j] : loop[i],
                 &b = loop[j].y() < loop[i].y() ? loop[i] : loop[j];
      const int end = first(b.y(), height);
      for (int y = first(a.y(), height); y < end; ++y)
        crossings[y - top].push_back(a.x() + (y + 0.5 - a.y()) * (b.x() - a.x()) / (b.y() - a.y()));
    }
  for (int y = top; y < bottom; ++y) {
    std::vector<double>& x = crossings[y - top];
    std::sort(x.begin(), x.end());
    for (std::size_t k = 0; k + 1 < x.size(); k += 2)
      if (const int begin = first(x[k], width), end = first(x[k + 1], width); begin < end) row(y, begin, end);
  }
}

}  // namespace terrazzo
