#include "nodes/bodies/carve/subdivide.h"

#include <algorithm>
#include <unordered_map>

namespace terrazzo::carve {

void subdivide(Mesh& mesh, double longest, const Work& work) {
  const double limit = longest * longest;
  const auto key = [](std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
  };
  for (bool changed = true; changed;) {
    work.check();
    changed = false;
    std::unordered_map<std::uint64_t, std::int32_t> middle;
    const auto split = [&](std::int32_t a, std::int32_t b) -> std::int32_t {
      // By value: the vector grows. The sum does not depend on the order.
      const Vec3 p = mesh.vertices[a], q = mesh.vertices[b];
      if ((p - q).squaredNorm() <= limit) return -1;
      const auto [at, added] = middle.try_emplace(key(a, b), static_cast<std::int32_t>(mesh.vertices.size()));
      if (added) mesh.vertices.push_back(0.5 * (p + q));
      return at->second;
    };
    std::vector<Triangle> out;
    out.reserve(mesh.triangles.size() * 2);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (t % 65536 == 0) work.check();
      Triangle corner = mesh.triangles[t];
      std::array<std::int32_t, 3> m;
      for (std::size_t k = 0; k < 3; ++k) m[k] = split(corner[k], corner[(k + 1) % 3]);
      const auto count = std::count_if(m.begin(), m.end(), [](std::int32_t i) { return i >= 0; });
      if (count == 0) {
        out.push_back(corner);
        continue;
      }
      changed = true;
      if (count == 3) {
        for (std::size_t k = 0; k < 3; ++k) out.push_back({corner[k], m[k], m[(k + 2) % 3]});
        out.push_back({m[0], m[1], m[2]});
        continue;
      }
      // Turned so that the first edge is split and, of two, the second one too.
      while (m[0] < 0 || (count == 2 && m[1] < 0)) {
        std::rotate(corner.begin(), corner.begin() + 1, corner.end());
        std::rotate(m.begin(), m.begin() + 1, m.end());
      }
      const auto [a, b, c] = corner;
      if (count == 1) {
        out.push_back({a, m[0], c});
        out.push_back({m[0], b, c});
        continue;
      }
      out.push_back({m[0], b, m[1]});
      const auto at = [&](std::int32_t i) { return mesh.vertices[i]; };
      if ((at(a) - at(m[1])).squaredNorm() <= (at(m[0]) - at(c)).squaredNorm()) {
        out.push_back({a, m[0], m[1]});
        out.push_back({a, m[1], c});
      } else {
        out.push_back({a, m[0], c});
        out.push_back({m[0], m[1], c});
      }
    }
    mesh.triangles = std::move(out);
  }
}

}  // namespace terrazzo::carve
