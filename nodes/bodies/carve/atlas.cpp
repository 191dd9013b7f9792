#include "nodes/bodies/carve/atlas.h"

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::carve {

Image bake_atlas(const Mesh& mesh, int size, const std::function<Vec3f(std::size_t t, const Vec3& p)>& color,
                 std::vector<CornerUv>& uv, const Work& work) {
  const std::size_t pairs = (mesh.triangles.size() + 1) / 2;
  int per_row = std::max(1, round_down(std::sqrt(double(pairs))));
  while (static_cast<std::size_t>(per_row) * per_row < pairs) ++per_row;
  const int cell = size / per_row;
  if (cell < 4)
    throw Error("bad-value",
                std::to_string(mesh.triangles.size()) + " triangles need a texture of at least " +
                    std::to_string(4 * per_row) + " pixels; it has " + std::to_string(size),
                "increase texture, or increase edge")
        .parameter("texture");
  // Of the second triangle of a pair, pixels are counted from the opposite corner.
  const int leg = cell - 3;
  Image out(size, size, 1, 1);
  uv.resize(mesh.triangles.size());
  work.parallel(pairs, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const int x0 = static_cast<int>(n % per_row) * cell;
      const int y0 = static_cast<int>(n / per_row) * cell;
      const std::size_t last = std::min(2 * n + 2, mesh.triangles.size());
      for (std::size_t t = 2 * n; t < last; ++t) {
        const bool second = t % 2 == 1;
        const auto pixel = [&](int i, int j) {
          return second ? std::pair(x0 + cell - 1 - i, y0 + cell - 1 - j) : std::pair(x0 + i, y0 + j);
        };
        const auto place = [&](int i, int j) {
          const auto [x, y] = pixel(i, j);
          return Eigen::Vector2f((float(x) + 0.5f) / float(size), (float(y) + 0.5f) / float(size));
        };
        uv[t] = {place(0, 0), place(leg, 0), place(0, leg)};
        const auto at = [&](std::size_t k) { return mesh.vertices[mesh.triangles[t][k]]; };
        const Vec3 a = at(0), b = at(1), c = at(2);
        for (int j = 0; j < cell; ++j)
          for (int i = 0; i + j <= cell - (second ? 2 : 1); ++i) {
            // Pixels beyond the longest edge have the color of its nearest point.
            double u = double(i) / leg, v = double(j) / leg;
            const double beyond = std::max(0.0, 0.5 * (u + v - 1));
            u = std::clamp(u - beyond, 0.0, 1.0);
            v = std::clamp(v - beyond, 0.0, 1.0 - u);
            const auto [x, y] = pixel(i, j);
            out.at(x, y) = color(t, a + u * (b - a) + v * (c - a));
          }
      }
    }
  });
  return out;
}

}  // namespace terrazzo::carve
