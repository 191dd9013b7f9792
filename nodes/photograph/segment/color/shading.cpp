#include "nodes/photograph/segment/color/shading.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo::segment {

LabImage shading_of(const Mosaic& m, const Clusters& clusters, const Work& work) {
  std::vector<Vec3f> residual;
  for (const auto& c : m.colors) residual.push_back(c - clusters.centers[clusters.nearest(c)]);
  // The field is smooth, so compute it on a coarse grid.
  const int cell = std::max(1, std::max(m.width, m.height) / 64);
  LabImage grid{(m.width + cell - 1) / cell, (m.height + cell - 1) / cell, {}};
  grid.pixels.assign(pixels_in(grid.width, grid.height), Vec3f::Zero());
  std::vector<float> count(grid.pixels.size(), 0);
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const std::size_t g = grid.index(x / cell, y / cell);
      grid.pixels[g] += residual[m.patches[m.index(x, y)] - 1];
      count[g] += 1;
    }
  for (std::size_t g = 0; g < count.size(); ++g) grid.pixels[g] /= count[g];
  grid = blur(std::move(grid), 8, work);
  LabImage out{m.width, m.height, {}};
  out.pixels.resize(m.patches.size());
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const float u = std::clamp((x + 0.5f) / cell - 0.5f, 0.0f, grid.width - 1.0f);
      const float v = std::clamp((y + 0.5f) / cell - 0.5f, 0.0f, grid.height - 1.0f);
      const int i = std::min<int>(u, std::max(0, grid.width - 2));
      const int j = std::min<int>(v, std::max(0, grid.height - 2));
      const int i1 = std::min(i + 1, grid.width - 1), j1 = std::min(j + 1, grid.height - 1);
      const float a = u - i, b = v - j;
      out.pixels[out.index(x, y)] =
          (1 - b) * ((1 - a) * grid.pixels[grid.index(i, j)] + a * grid.pixels[grid.index(i1, j)]) +
          b * ((1 - a) * grid.pixels[grid.index(i, j1)] + a * grid.pixels[grid.index(i1, j1)]);
    }
  return out;
}

float strength_of(const LabImage& field) {
  double squares = 0;
  for (const auto& p : field.pixels) squares += p.cast<double>().squaredNorm();
  return std::sqrt(squares / std::max<double>(1, static_cast<double>(field.pixels.size())));
}

void take_shading_away(Mosaic& m, const LabImage& shading, const Work& work) {
  for (std::size_t i = 0; i < shading.pixels.size(); ++i) {
    m.image.pixels[i] -= shading.pixels[i];
    m.smooth.pixels[i] -= shading.pixels[i];
  }
  make_patches(m, work);
}

}  // namespace terrazzo::segment
