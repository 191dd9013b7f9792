#include "nodes/shapes/shape_estimate/self_intersections.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace terrazzo::shape_estimate {

namespace {

// Whether the open segment a–b crosses the interior of the triangle (Möller, Trumbore 1997).
bool passes(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q, const Vec3& r) {
  const Vec3 d = b - a, e = q - p, f = r - p, h = d.cross(f);
  const double det = e.dot(h), tiny = 1e-12 * e.norm() * f.norm() * d.norm();
  if (std::abs(det) <= tiny) return false;
  const Vec3 s = a - p;
  const double u = s.dot(h) / det;
  if (u <= 1e-9 || u >= 1 - 1e-9) return false;
  const Vec3 k = s.cross(e);
  const double v = d.dot(k) / det, t = f.dot(k) / det;
  return v > 1e-9 && u + v < 1 - 1e-9 && t > 1e-9 && t < 1 - 1e-9;
}

bool cut_each_other(const Mesh& m, const Triangle& a, const Triangle& b) {
  int shared = 0;
  for (const int v : a) shared += std::find(b.begin(), b.end(), v) != b.end();
  if (shared >= 2) return false;
  // An edge at a shared corner cannot cross the interior of the other triangle; the strict test excludes it.
  for (int k = 0; k < 3; ++k) {
    if (passes(m.vertices[a[k]], m.vertices[a[(k + 1) % 3]], m.vertices[b[0]], m.vertices[b[1]],
               m.vertices[b[2]]))
      return true;
    if (passes(m.vertices[b[k]], m.vertices[b[(k + 1) % 3]], m.vertices[a[0]], m.vertices[a[1]],
               m.vertices[a[2]]))
      return true;
  }
  return false;
}

}  // namespace

std::int64_t self_intersections(const Mesh& mesh, const Work& work) {
  const std::size_t n = mesh.triangles.size();
  if (n == 0) return 0;
  Vec3 low = mesh.vertices[0], high = low;
  for (const auto& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const int cells = std::clamp<int>(std::sqrt(static_cast<double>(n)) / 2, 1, 64);
  const Vec3 step = ((high - low) / cells).cwiseMax(1e-300);
  struct Box {
    Vec3i low, high;
  };
  std::vector<Box> box(n);
  std::vector<std::vector<int>> grid(static_cast<std::size_t>(cells) * cells * cells);
  const auto cell = [&](const Vec3& p) {
    return Vec3i((p - low).cwiseQuotient(step).cast<int>().cwiseMax(0).cwiseMin(cells - 1));
  };
  const auto each = [&](const Box& b, auto&& use) {
    for (int z = b.low.z(); z <= b.high.z(); ++z)
      for (int y = b.low.y(); y <= b.high.y(); ++y)
        for (int x = b.low.x(); x <= b.high.x(); ++x)
          use((static_cast<std::size_t>(z) * cells + y) * cells + x, Vec3i(x, y, z));
  };
  for (std::size_t t = 0; t < n; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    box[t] = {cell(p.cwiseMin(q).cwiseMin(r)), cell(p.cwiseMax(q).cwiseMax(r))};
    each(box[t], [&](std::size_t at, const Vec3i&) { grid[at].push_back(static_cast<int>(t)); });
  }
  return work.reduce<std::int64_t>(
      n, 256, 0,
      [&](std::size_t begin, std::size_t end) {
        std::int64_t count = 0;
        for (std::size_t t = begin; t < end; ++t)
          each(box[t], [&](std::size_t at, const Vec3i& where) {
            for (const int o : grid[at]) {
              if (o <= static_cast<int>(t)) continue;
              // A pair is tested only in the first cell that both reach.
              if (where != box[t].low.cwiseMax(box[o].low)) continue;
              count += cut_each_other(mesh, mesh.triangles[t], mesh.triangles[o]);
            }
          });
        return count;
      },
      [](std::int64_t a, std::int64_t b) { return a + b; });
}

}  // namespace terrazzo::shape_estimate
