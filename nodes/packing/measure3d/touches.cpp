#include <algorithm>
#include <cmath>
#include <memory>

#include "nodes/common/geometry/mesh/aabb_tree.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/data/indices.h"
#include "nodes/packing/measure3d/bodies.h"
#include "nodes/packing/rigid/audit.h"

namespace terrazzo::measure3d {
namespace {

constexpr double kNet = 1.0 / 16;  // of a particle's size
constexpr int kMostParts = 32;     // per edge of a triangle

struct Solid {
  const Mesh* mesh;
  AabbTree tree;
  double radius;
  explicit Solid(const Mesh& m) : mesh(&m), tree(m, 4), radius(mesh_bounding_radius(m)) {}
};

struct Placed {
  const Solid* solid;
  Mat3 turn;
  double scale, size;
};

// Area of a's surface that is nearer than `gap` to b, mm². `offset` is b's center minus a's.
double near_area(const Placed& a, const Placed& b, const Vec3& offset, double gap) {
  const Mat3 turn = b.turn.transpose() * a.turn * (a.scale / b.scale);
  const Vec3 shift = b.turn.transpose() * offset / b.scale;
  const double limit = gap / b.scale, reach = b.solid->radius + limit;
  const double step = kNet * a.size / b.scale;
  double sum = 0;
  std::vector<int> stack{0};
  while (!stack.empty()) {
    const int k = stack.back();
    stack.pop_back();
    const auto& node = a.solid->tree.nodes[k];
    const Vec3 middle = turn * node.box.center() - shift;
    if (middle.norm() > reach + 0.5 * (node.box.high - node.box.low).norm() * a.scale / b.scale) continue;
    if (node.right != 0) {
      stack.insert(stack.end(), {node.right, k + 1});
      continue;
    }
    for (int m = node.first; m < node.first + node.count; ++m) {
      const Triangle& t = a.solid->mesh->triangles[a.solid->tree.triangles[m]];
      Vec3 c[3];
      for (int v = 0; v < 3; ++v) c[v] = turn * a.solid->mesh->vertices[t[v]] - shift;
      const Vec3 u = c[1] - c[0], w = c[2] - c[0];
      const double longest = std::max({u.norm(), w.norm(), (w - u).norm()});
      const int parts = std::clamp(round_up(longest / step), 1, kMostParts);
      const double part = 0.5 * u.cross(w).norm() / (parts * parts);
      // The centers of parts² equal triangles: those that point up, then those that point down.
      for (int i = 0; i < parts; ++i)
        for (int j = 0; i + j < parts; ++j)
          for (int down = 0; down < (i + j + 1 < parts ? 2 : 1); ++down) {
            const double third = (1.0 + down) / 3;
            const Vec3 p = c[0] + ((i + third) * u + (j + third) * w) / parts;
            if (p.norm() <= reach &&
                squared_distance(*b.solid->mesh, b.solid->tree, p, limit * limit) < limit * limit)
              sum += part;
          }
    }
  }
  return sum * b.scale * b.scale;
}

}  // namespace

std::vector<Touch> touches_of(const Particles& particles, const Shapes& shapes, double gap,
                              const Work& work) {
  auto found = packing::audit(shapes, particles, gap, work.part(0, 0.6)).found;
  found.erase(std::remove_if(found.begin(), found.end(), [](const auto& pair) { return pair.a == pair.b; }),
              found.end());
  std::vector<std::unique_ptr<Solid>> solids(shapes.shapes.size());
  for (const auto& pair : found)
    for (const std::int32_t p : {pair.a, pair.b}) {
      const std::size_t s = particles.shape[p];
      if (!solids[s]) solids[s] = std::make_unique<Solid>(shapes.shapes[s].mesh);
    }
  const auto placed = [&](std::int32_t p) {
    const std::size_t i = p;
    const Solid* solid = solids[particles.shape[i]].get();
    return Placed{solid, particles.orientation[i].toRotationMatrix(), particles.scale[i],
                  2 * solid->radius * particles.scale[i]};
  };
  std::vector<Touch> out(found.size());
  work.part(0.6, 1).parallel(found.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      work.check();
      const auto& pair = found[k];
      const Placed a = placed(pair.a), b = placed(pair.b);
      double area = 0;
      for (int image = 0; image < 27; ++image) {
        const Vec3 shift(image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1);
        const Vec3 offset =
            particles.position[pair.b] - particles.position[pair.a] + shift.cwiseProduct(particles.box);
        if (offset.norm() >= 0.5 * (a.size + b.size) + gap) continue;
        area += 0.5 * (near_area(a, b, offset, gap) + near_area(b, a, -offset, gap));
      }
      out[k] = {pair.a, pair.b, area};
    }
  });
  return out;
}

}  // namespace terrazzo::measure3d
