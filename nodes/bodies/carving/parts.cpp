#include "nodes/bodies/carving/parts.h"

#include "graph/diagnostic.h"
#include "nodes/bodies/carving/broken_block.h"
#include "nodes/bodies/carving/hollows.h"

namespace terrazzo::carving {
namespace {

void add_instance(Mesh& out, const Mesh& mesh, const RayScene::Instance& instance) {
  const std::int32_t first = out.vertices.size();
  const Mat3 linear = instance.linear.cast<double>();
  const Vec3 offset = instance.offset.cast<double>();
  for (const Vec3& v : mesh.vertices) out.vertices.push_back(linear * v + offset);
  for (const Triangle& t : mesh.triangles)
    out.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

void remove_voids(BodyParts& parts, const Voids& voids) {
  if (!voids.particles || voids.particles->void_count() == 0) return;
  Eigen::AlignedBox3d bounds;
  for (const Vec3& v : parts.base.mesh.vertices) bounds.extend(v);
  for (const VoidImage& i : void_images(voids, bounds.cast<float>()))
    add_instance(parts.removed, voids.shapes->shapes[i.instance.mesh].mesh, i.instance);
}

}  // namespace

// The cells of a grid of 2 × 2 × 2 that are left; their outer faces.
BodyParts block_parts(const Vec3f& period, double cut, const Voids& voids) {
  BodyParts parts;
  parts.base.name = "block";
  const Vec3 size = period.cast<double>();
  const int n = cut > 0 ? 2 : 1;
  std::vector<double> at[3];
  for (int k = 0; k < 3; ++k) {
    at[k] = {0, size[k]};
    if (n == 2) at[k].insert(at[k].begin() + 1, k == 1 ? size[k] * cut : size[k] * (1 - cut));
  }
  const auto filled = [&](const Vec3i& c) {
    if (c.minCoeff() < 0 || c.maxCoeff() >= n) return false;
    return n == 1 || c != Vec3i(1, 0, 1);
  };
  Mesh& mesh = parts.base.mesh;
  std::vector<std::int32_t> number(27, -1);
  const auto vertex = [&](const Vec3i& g) {
    std::int32_t& i = number[(g.z() * 3 + g.y()) * 3 + g.x()];
    if (i < 0) {
      i = mesh.vertices.size();
      mesh.vertices.push_back(Vec3(at[0][g.x()], at[1][g.y()], at[2][g.z()]));
    }
    return i;
  };
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const Vec3i cell(x, y, z);
        if (!filled(cell)) continue;
        for (int k = 0; k < 3; ++k)
          for (const int side : {0, 1}) {
            Vec3i beside = cell;
            beside[k] += side ? 1 : -1;
            if (filled(beside)) continue;
            Vec3i corner = cell, u = Vec3i::Zero(), v = Vec3i::Zero();
            corner[k] += side;
            u[(k + 1) % 3] = 1;
            v[(k + 2) % 3] = 1;
            if (!side) std::swap(u, v);
            const std::int32_t a = vertex(corner), b = vertex(corner + u), c = vertex(corner + u + v),
                               d = vertex(corner + v);
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
          }
      }
  remove_voids(parts, voids);
  return parts;
}

Mesh placed_object(const Shape& shape) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : shape.mesh.vertices) box.extend(v);
  const double longest = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (!(longest > 0) || !std::isfinite(longest))
    throw Error("bad-mesh", "the object '" + shape.name + "' has no extent");
  Mesh mesh = shape.mesh;
  for (Vec3& v : mesh.vertices) v = (v - box.min()) * (1 / longest);
  return mesh;
}

BodyParts object_parts(const Shape& object, const Voids& voids) {
  BodyParts parts;
  parts.base.name = object.name;
  parts.base.smooth = object.smooth;
  parts.base.mesh = placed_object(object);
  remove_voids(parts, voids);
  return parts;
}

BodyParts fracture_parts(const Particles& particles, const Shapes& shapes, double level, double roughness,
                         std::uint64_t seed) {
  const BrokenBlock block(particles, shapes, level, roughness, seed);
  BodyParts parts;
  parts.base.name = "fracture";
  parts.base.smooth = true;
  // Everything under the face, closed below: the box cuts it off at the block's sides.
  Mesh& mesh = parts.base.mesh;
  mesh = block.under_the_face().mesh;
  constexpr int kN = BrokenBlock::kFaceSteps;
  std::vector<std::int32_t> rim;
  for (int i = 0; i < kN; ++i) rim.push_back(i);
  for (int j = 0; j < kN; ++j) rim.push_back(j * (kN + 1) + kN);
  for (int i = kN; i > 0; --i) rim.push_back(kN * (kN + 1) + i);
  for (int j = kN; j > 0; --j) rim.push_back(j * (kN + 1));
  const std::int32_t first = mesh.vertices.size();
  const std::int32_t count = rim.size();
  for (const std::int32_t v : rim) {
    const Vec3 p = mesh.vertices[v];
    mesh.vertices.push_back(Vec3(p.x(), p.y(), -0.05));
  }
  mesh.vertices.push_back(Vec3(0.5 * block.size().x(), 0.5 * block.size().y(), -0.05));
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t next = (i + 1) % count;
    const std::int32_t a = rim[i], b = rim[next];
    mesh.triangles.push_back({a, first + i, first + next});
    mesh.triangles.push_back({a, first + next, b});
    mesh.triangles.push_back({first + i, first + count, first + next});
  }
  for (std::size_t i = 0; i < block.instances().size(); ++i) {
    const RayScene::Instance& instance = block.instances()[i];
    add_instance(block.images()[i].stays ? parts.kept : parts.removed, shapes.shapes[instance.mesh].mesh,
                 instance);
  }
  parts.box = {Vec3(0, 0, 0), Vec3(block.size().x(), block.size().y(), block.top() + 0.05)};
  return parts;
}

}  // namespace terrazzo::carving
