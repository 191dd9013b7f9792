#include "nodes/shapes/shape_estimate/methods/refine.h"

#include <algorithm>
#include <map>
#include <utility>

namespace terrazzo::shape_estimate {

void split_edges(Mesh& mesh, double limit) {
  using Edge = std::pair<std::int32_t, std::int32_t>;
  for (int round = 0; round < 12; ++round) {
    const auto longest = [&](const Triangle& t) {
      Edge best{-1, -1};
      double length = -1;
      for (int k = 0; k < 3; ++k) {
        const Edge e = std::minmax(t[k], t[(k + 1) % 3]);
        const double l = (mesh.vertices[e.first] - mesh.vertices[e.second]).squaredNorm();
        if (l > length || (l == length && e < best)) {
          best = e;
          length = l;
        }
      }
      return best;
    };
    std::map<Edge, int> votes;
    for (const auto& t : mesh.triangles) {
      const Edge e = longest(t);
      if ((mesh.vertices[e.first] - mesh.vertices[e.second]).norm() > limit) ++votes[e];
    }
    std::map<Edge, std::int32_t> middle;
    for (const auto& [e, n] : votes)
      if (n == 2) {
        middle[e] = mesh.vertices.size();
        mesh.vertices.push_back((mesh.vertices[e.first] + mesh.vertices[e.second]) / 2);
      }
    if (middle.empty()) return;
    const std::size_t count = mesh.triangles.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Triangle t = mesh.triangles[i];
      const Edge e = longest(t);
      const auto found = middle.find(e);
      if (found == middle.end()) continue;
      for (int k = 0; k < 3; ++k) {
        if (Edge(std::minmax(t[k], t[(k + 1) % 3])) != e) continue;
        mesh.triangles[i] = {t[k], found->second, t[(k + 2) % 3]};
        mesh.triangles.push_back({found->second, t[(k + 1) % 3], t[(k + 2) % 3]});
      }
    }
  }
}

std::vector<Vec3> smoothed(const Mesh& mesh, int rounds) {
  std::vector<Vec3> at = mesh.vertices;
  for (int r = 0; r < rounds; ++r) {
    std::vector<Vec3> sum(at.size(), Vec3::Zero());
    std::vector<int> n(at.size(), 0);
    for (const auto& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        sum[t[k]] += at[t[(k + 1) % 3]] + at[t[(k + 2) % 3]];
        n[t[k]] += 2;
      }
    for (std::size_t v = 0; v < at.size(); ++v) at[v] = 0.5 * at[v] + 0.5 * sum[v] / std::max(1, n[v]);
  }
  return at;
}

}  // namespace terrazzo::shape_estimate
