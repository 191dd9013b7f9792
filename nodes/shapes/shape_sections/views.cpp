#include "nodes/shapes/shape_sections/views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/data/indices.h"

namespace terrazzo::shape_sections {

namespace {

constexpr int kFine = 3;  // samples per pixel edge

// One view: x right, y up, z towards the viewer.
void draw_view(const RenderMesh& mesh, const Mat3& view, double scale, int cell, int left, int top,
               Image& image, const Work& work) {
  const int n = cell * kFine;
  std::vector<float> depth(static_cast<std::size_t>(n) * n, -std::numeric_limits<float>::infinity()),
      shade(depth.size(), 1);
  // Light from the upper left, plus a little ambient light.
  const Vec3 lamp = Vec3(-0.5, 0.6, 0.62).normalized();
  std::vector<Vec3> at(mesh.positions.size());
  std::vector<double> light(at.size());
  for (std::size_t v = 0; v < at.size(); ++v) {
    const Vec3 p = view.transpose() * mesh.positions[v], normal = view.transpose() * mesh.normals[v];
    at[v] = {n / 2.0 + scale * kFine * p.x(), n / 2.0 - scale * kFine * p.y(), p.z()};
    light[v] = 0.14 + 0.1 * normal.y() + 0.72 * std::max(0.0, normal.dot(lamp));
  }
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    if (t % 3000 == 0) work.check();
    const auto i = mesh.indices[t], j = mesh.indices[t + 1], k = mesh.indices[t + 2];
    const Vec3 &a = at[i], &b = at[j], &c = at[k];
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area >= 0) continue;  // y points down: triangles that face the viewer are clockwise
    const int x0 = std::max<int>(0, std::min({a.x(), b.x(), c.x()})),
              x1 = std::min<int>(n - 1, std::max({a.x(), b.x(), c.x()})),
              y0 = std::max<int>(0, std::min({a.y(), b.y(), c.y()})),
              y1 = std::min<int>(n - 1, std::max({a.y(), b.y(), c.y()}));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double u = ((b.x() - px) * (c.y() - py) - (b.y() - py) * (c.x() - px)) / area,
                     v = ((c.x() - px) * (a.y() - py) - (c.y() - py) * (a.x() - px)) / area, w = 1 - u - v;
        if (u < 0 || v < 0 || w < 0) continue;
        const float z = u * a.z() + v * b.z() + w * c.z();
        const std::size_t pixel = pixel_at(x, y, n);
        if (z <= depth[pixel]) continue;
        depth[pixel] = z;
        shade[pixel] = u * light[i] + v * light[j] + w * light[k];
      }
  }
  for (int y = 0; y < cell; ++y)
    for (int x = 0; x < cell; ++x) {
      float sum = 0;
      for (int s = 0; s < kFine * kFine; ++s)
        sum += shade[static_cast<std::size_t>(y * kFine + s / kFine) * n + x * kFine + s % kFine];
      image.at(left + x, top + y) = Vec3f::Constant(sum / (kFine * kFine));
    }
}

}  // namespace

Image views_of(const Shapes& shapes, int cell, const Work& work) {
  const int rows = shapes.shapes.size();
  double reach = 0;
  for (const Shape& s : shapes.shapes)
    reach = std::max(reach, mesh_bounding_radius(s.mesh, mesh_centroid(s.mesh)));
  const double scale = cell / (2.1 * reach);
  Image image(3 * cell, rows * cell, 1, 1 / scale, Vec3f::Ones());
  work.parallel(static_cast<std::size_t>(rows) * 3, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Shape& s = shapes.shapes[i / 3];
      Shape centerd = s;
      transform(centerd.mesh, Mat3::Identity(), -mesh_centroid(s.mesh));
      const Mat3 axes = volume_axes(s.mesh);
      const int side = i % 3;
      Mat3 view;
      view.col(2) = axes.col(2 - side);
      view.col(0) = side < 2 ? Vec3(axes.col(0)) : Vec3(axes.col(1));
      view.col(1) = view.col(2).cross(view.col(0));
      draw_view(render_mesh(centerd), view, scale, cell, side * cell, static_cast<int>(i / 3) * cell, image,
                work);
    }
  });
  return image;
}

}  // namespace terrazzo::shape_sections
