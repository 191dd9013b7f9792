#include "nodes/shapes/load_mesh/fill.h"

#include <limits>

namespace terrazzo::load_mesh {

std::vector<Triangle> least_area_triangulation(const std::vector<Vec3>& polygon,
                                               const std::function<bool(int, int)>& forbidden) {
  const int n = polygon.size();
  std::vector<Triangle> out;
  if (n < 3 || polygon.size() > kLargestPolygon) return out;
  if (n == 3) return {{0, 1, 2}};
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<double> cost(static_cast<std::size_t>(n) * n, 0);
  std::vector<int> apex(static_cast<std::size_t>(n) * n, -1);
  for (int span = 2; span < n; ++span)
    for (int i = 0; i + span < n; ++i) {
      const int k = i + span;
      double best = kNone;
      int at = -1;
      if (span == n - 1 || !forbidden || !forbidden(i, k))
        for (int j = i + 1; j < k; ++j) {
          const double area = (polygon[j] - polygon[i]).cross(polygon[k] - polygon[i]).norm() / 2;
          const double total = cost[i * n + j] + cost[j * n + k] + area;
          if (total < best) {
            best = total;
            at = j;
          }
        }
      cost[i * n + k] = best;
      apex[i * n + k] = at;
    }
  std::vector<std::pair<int, int>> open{{0, n - 1}};
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    if (k - i < 2) continue;
    const int j = apex[i * n + k];
    if (j < 0) return {};
    out.push_back({i, j, k});
    open.push_back({i, j});
    open.push_back({j, k});
  }
  return out;
}

}  // namespace terrazzo::load_mesh
