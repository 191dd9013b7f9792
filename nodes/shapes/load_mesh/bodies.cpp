#include "nodes/shapes/load_mesh/bodies.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"

namespace terrazzo::load_mesh {
namespace {

// A side of a triangle, for sorting by edge.
struct Side {
  std::int32_t low = 0, high = 0;
  std::int32_t triangle = 0;
  bool forward = false;  // whether the triangle runs from low to high
};

std::vector<Side> sorted_sides(const Mesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(mesh.triangles.size() * 3);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  return sides;
}

// The angle of a triangle around its edge from low to high, in radians.
class AngleAround {
 public:
  AngleAround(const Mesh& mesh, const Side& edge) : mesh_(mesh), from_(mesh.vertices[edge.low]) {
    axis_ = mesh.vertices[edge.high] - from_;
    const double length = axis_.norm();
    if (length > 0) axis_ /= length;
    x_ = axis_.unitOrthogonal();
    y_ = axis_.cross(x_);
  }
  double operator()(const Side& side) const {
    Vec3 apex = from_;
    for (const std::int32_t v : mesh_.triangles[side.triangle])
      if (v != side.low && v != side.high) apex = mesh_.vertices[v];
    const Vec3 d = apex - from_;
    return std::atan2(d.dot(y_), d.dot(x_));
  }

 private:
  const Mesh& mesh_;
  Vec3 from_, axis_, x_, y_;
};

// Joins the triangles at an edge of more than two. Seen along the edge, a body begins at a triangle that runs
// backward and ends at the next one that runs forward. If triangles are left over, the edge is faulty and
// joins all.
void join_bodies_at_edge(const Mesh& mesh, const Side* begin, const Side* end, DisjointSets& surfaces) {
  constexpr double kCoincident = 1e-6;  // radians between triangles of two bodies that share a face
  const AngleAround angle(mesh, *begin);
  std::vector<std::pair<const Side*, const Side*>> pairs;
  std::vector<const Side*> taken;
  for (const Side* back = begin; back != end; ++back) {
    if (back->forward) continue;
    const Side* next = nullptr;
    double least = 0;
    for (const Side* side = begin; side != end; ++side) {
      if (!side->forward) continue;
      double turn = angle(*side) - angle(*back);
      while (turn < kCoincident) turn += 2 * std::numbers::pi;
      if (!next || turn < least) {
        next = side;
        least = turn;
      }
    }
    if (next) {
      pairs.emplace_back(back, next);
      taken.push_back(next);
    }
  }
  std::sort(taken.begin(), taken.end());
  const bool unique = std::adjacent_find(taken.begin(), taken.end()) == taken.end();
  if (unique && 2 * pairs.size() == static_cast<std::size_t>(end - begin)) {
    for (const auto& [a, b] : pairs) surfaces.join(a->triangle, b->triangle);
  } else {
    for (const Side* side = begin; side != end; ++side) surfaces.join(begin->triangle, side->triangle);
  }
}

void append(Mesh& to, const Mesh& from) {
  const std::int32_t first = to.vertices.size();
  to.vertices.insert(to.vertices.end(), from.vertices.begin(), from.vertices.end());
  for (const Triangle& t : from.triangles) to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

Aabb box_of(const Mesh& mesh) {
  Aabb box;
  for (const Vec3& v : mesh.vertices) box.add(v);
  return box;
}

// The closed surfaces of a file with what the search for cavities needs of each.
struct Surface {
  const Mesh* mesh;
  double volume;
  Aabb box;
  std::optional<MeshDistance> distance = {};  // once it is asked for

  bool contains(const Surface& other) {
    const double margin = 1e-6 * (box.high - box.low).norm();
    if (((other.box.low - box.low).array() < -margin).any() ||
        ((box.high - other.box.high).array() < -margin).any())
      return false;
    if (!distance) distance.emplace(*mesh);
    bool inside = false;
    for (const Vec3& v : other.mesh->vertices) {
      const double d = distance->signed_distance(v);
      if (d > margin) return false;
      inside = inside || d < -margin;
    }
    return inside;
  }
};

}  // namespace

std::vector<Mesh> connected_surfaces(const Mesh& mesh) {
  const auto sides = sorted_sides(mesh);
  DisjointSets sets(mesh.triangles.size());
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
    if (end - i == 2)
      sets.join(sides[i].triangle, sides[i + 1].triangle);
    else if (end - i > 2)
      join_bodies_at_edge(mesh, sides.data() + i, sides.data() + end, sets);
    i = end;
  }
  std::vector<std::vector<std::size_t>> triangles;  // of each surface
  std::vector<int> number(mesh.triangles.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    int& surface = number[sets.find(static_cast<std::int32_t>(t))];
    if (surface < 0) {
      surface = triangles.size();
      triangles.emplace_back();
    }
    triangles[surface].push_back(t);
  }
  std::vector<Mesh> out(triangles.size());
  std::vector<std::size_t> user(mesh.vertices.size(), triangles.size());  // the last surface with this vertex
  std::vector<std::int32_t> name(mesh.vertices.size());
  for (std::size_t s = 0; s < out.size(); ++s)
    for (const std::size_t t : triangles[s]) {
      Triangle renamed = mesh.triangles[t];
      for (auto& v : renamed) {
        const std::size_t old = v;
        if (user[old] != s) {
          user[old] = s;
          name[old] = out[s].vertices.size();
          out[s].vertices.push_back(mesh.vertices[old]);
        }
        v = name[old];
      }
      out[s].triangles.push_back(renamed);
    }
  return out;
}

Bodies bodies_of(const std::vector<Mesh>& surfaces, const Work& work) {
  // A closed surface without volume gives a volume of rounding errors.
  constexpr double kFlat = 1e-12;  // of the cube of the extent
  Bodies out;
  std::vector<Surface> outer;
  std::vector<std::pair<std::size_t, Surface>> inward;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    Surface s{&surfaces[i], mesh_volume(surfaces[i]), box_of(surfaces[i])};
    const double extent = (s.box.high - s.box.low).norm();
    if (std::abs(s.volume) <= kFlat * extent * extent * extent)
      out.flat.push_back(i);
    else if (s.volume < 0)
      inward.emplace_back(i, std::move(s));
    else
      outer.push_back(std::move(s));
  }
  for (const Surface& s : outer) out.bodies.push_back(*s.mesh);
  for (const auto& [number, cavity] : inward) {
    work.check();
    std::optional<std::size_t> around;
    for (std::size_t b = 0; b < outer.size(); ++b)
      if ((!around || outer[b].volume < outer[*around].volume) && outer[b].contains(cavity)) around = b;
    if (around)
      append(out.bodies[*around], *cavity.mesh);
    else
      out.inverted.push_back(number);
  }
  return out;
}

}  // namespace terrazzo::load_mesh
