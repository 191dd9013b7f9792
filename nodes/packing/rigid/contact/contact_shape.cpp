#include "nodes/packing/rigid/contact/contact_shape.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "nodes/common/geometry/mesh/aabb_tree.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/vertex_normals.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "nodes/packing/rigid/simplify.h"

namespace terrazzo::packing {
namespace {

constexpr int kCells = 40;  // grid cells across the shape
constexpr int kCoarse = 96, kFine = 1000;
// Most contacts miss far less than the worst case. The audit finds the few others and widens their margin.
constexpr double kAllowance = 0.15;
constexpr int kLeaf = 4;
// Radius of a packed sphere, as a fraction of the way from the sphere of the mesh's volume to its corners:
// less would need many tries to rotate the corners away.
constexpr double kTowardsCorners = 0.15;
constexpr double kSimplify = 0.005;  // largest deviation of the mesh for contact, in sizes
constexpr std::size_t kFaces = 40;   // largest number of faces of a polyhedron tested by separating axes

Element point_element(const Vec3& p) {
  Element e;
  for (int a = 0; a < 3; ++a) e.center[a] = p[a];
  return e;
}

Element segment_element(const Vec3& p, const Vec3& q) {
  Element e = point_element(0.5 * (p + q));
  for (int a = 0; a < 3; ++a) e.half[a] = 0.5 * (q[a] - p[a]);
  e.half_length = 0.5 * (q - p).norm();
  return e;
}

struct Edge {
  int a, b;
  Vec3 n[2];
  int apex[2];
  int faces = 0;
};

std::map<std::pair<int, int>, Edge> edges_of(const Mesh& mesh) {
  std::map<std::pair<int, int>, Edge> edges;
  for (const auto& t : mesh.triangles) {
    const Vec3 n =
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    for (int k = 0; k < 3; ++k) {
      const std::pair<int, int> key = std::minmax(t[k], t[(k + 1) % 3]);
      Edge& e = edges[key];
      e.a = key.first;
      e.b = key.second;
      if (e.faces < 2) {
        e.n[e.faces] = n.norm() > 0 ? n.normalized() : Vec3::Zero();
        e.apex[e.faces] = t[(k + 2) % 3];
      }
      ++e.faces;
    }
  }
  return edges;
}

// Convex edges with an angle between their faces' normals of more than `angle` (radians).
std::vector<std::pair<int, int>> convex_edges(const Mesh& mesh, double angle) {
  std::vector<std::pair<int, int>> result;
  for (const auto& [key, e] : edges_of(mesh)) {
    if (e.faces != 2 || e.n[0].isZero() || e.n[1].isZero()) continue;
    if (e.n[0].dot(e.n[1]) > std::cos(angle)) continue;
    const bool convex = e.n[0].dot(mesh.vertices[e.apex[1]] - mesh.vertices[e.a]) < 0;
    if (convex) result.push_back(key);
  }
  return result;
}

struct Choice {
  std::vector<int> order;  // vertices, most important first
  double missed = 0;       // how deep a flat surface can penetrate between the chosen vertices
};

// First chooses vertices far from each other, then those that protrude most beyond the tangent planes
// through their chosen neighbors.
Choice choose_vertices(const Mesh& mesh, double radius, std::vector<bool> covered, const Work& work) {
  const auto normal = vertex_normals(mesh);
  std::vector<int> candidates;
  const std::size_t stride = 1 + mesh.vertices.size() / 8000;
  for (std::size_t v = 0; v < mesh.vertices.size(); v += stride)
    if (!normal[v].isZero()) candidates.push_back(v);
  std::vector<double> distance(candidates.size(), 1e300), protrusion(candidates.size(), radius);
  Choice choice;
  const double near = 0.5 * radius;
  const auto take = [&](std::size_t k) {
    const Vec3 p = mesh.vertices[candidates[k]];
    for (std::size_t m = 0; m < candidates.size(); ++m) {
      const Vec3 d = mesh.vertices[candidates[m]] - p;
      const double r = d.norm();
      distance[m] = std::min(distance[m], r);
      if (r < near) protrusion[m] = std::min(protrusion[m], std::max(0.0, normal[candidates[m]].dot(d)));
    }
    distance[k] = protrusion[k] = 0;
  };
  for (std::size_t k = 0; k < candidates.size(); ++k)
    if (covered[candidates[k]]) take(k);
  const int spread = kCoarse / 2;
  while (count_of(choice.order) < kFine) {
    work.check();
    const auto& need = count_of(choice.order) < spread ? distance : protrusion;
    const auto worst = std::max_element(need.begin(), need.end());
    if (worst == need.end()) break;
    if (&need == &protrusion && *worst < 1e-4 * radius) break;
    if (!(*worst > 0)) break;
    const std::size_t k = worst - need.begin();
    choice.order.push_back(candidates[k]);
    take(k);
  }
  if (!protrusion.empty()) choice.missed = *std::max_element(protrusion.begin(), protrusion.end());
  return choice;
}

void split(ElementTree& tree, int first, int count) {
  const std::size_t me = tree.nodes.size();
  tree.nodes.emplace_back();
  Vec3f low = Vec3f::Constant(1e30f), high = Vec3f::Constant(-1e30f);
  for (int k = first; k < first + count; ++k) {
    const Eigen::Map<const Vec3f> c(tree.elements[k].center);
    low = low.cwiseMin(c);
    high = high.cwiseMax(c);
  }
  const Vec3f center = 0.5f * (low + high);
  float radius = 0;
  for (int k = first; k < first + count; ++k) {
    const Element& e = tree.elements[k];
    radius = std::max(radius, (Eigen::Map<const Vec3f>(e.center) - center).norm() + e.half_length);
  }
  ElementTree::Node node{
      {center[0], center[1], center[2]}, radius * 1.00001f, 0, first, count <= kLeaf ? count : 0};
  if (count > kLeaf) {
    int axis;
    (high - low).maxCoeff(&axis);
    const int half = count / 2;
    std::stable_sort(tree.elements.begin() + first, tree.elements.begin() + first + count,
                     [axis](const Element& a, const Element& b) { return a.center[axis] < b.center[axis]; });
    split(tree, first, half);
    split(tree, first + half, count - half);
  }
  node.next = tree.nodes.size();
  tree.nodes[me] = node;
}

ElementTree make_tree(std::vector<Element> elements) {
  ElementTree tree;
  tree.elements = std::move(elements);
  if (!tree.elements.empty()) split(tree, 0, tree.elements.size());
  return tree;
}

// The largest inscribed ball, and others at least 0.8 radii away from the previous ones.
std::vector<Ball> inner_balls(const Mesh& mesh, const DistanceField& field) {
  constexpr int kSteps = 20, kBalls = 6;
  Aabb box;
  for (const auto& v : mesh.vertices) box.add(v);
  std::vector<Ball> samples;
  for (int k = 0; k < kSteps; ++k)
    for (int j = 0; j < kSteps; ++j)
      for (int i = 0; i < kSteps; ++i) {
        const Vec3 u((i + 0.5) / kSteps, (j + 0.5) / kSteps, (k + 0.5) / kSteps);
        const Vec3 p = box.low + u.cwiseProduct(box.high - box.low);
        Ball ball{{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}, 0};
        ball.radius = -field.value(ball.center);
        if (ball.radius > 0) samples.push_back(ball);
      }
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Ball& a, const Ball& b) { return a.radius > b.radius; });
  std::vector<Ball> balls;
  for (const Ball& e : samples) {
    bool far = e.radius > 0.3f * samples[0].radius;
    for (const Ball& b : balls)
      far = far &&
            (Eigen::Map<const Vec3f>(e.center) - Eigen::Map<const Vec3f>(b.center)).norm() > 0.8f * b.radius;
    if (far) balls.push_back(e);
    if (balls.size() == kBalls) break;
  }
  for (auto& b : balls) b.radius *= 0.95f;  // clear of the surface, where the elements are tested
  return balls;
}

// The 95th percentile of the field's error over surface samples.
double field_error(const Mesh& mesh, const DistanceField& field) {
  std::vector<double> errors;
  const std::size_t stride = 1 + mesh.triangles.size() / 4000;
  for (std::size_t k = 0; k < mesh.triangles.size(); k += stride) {
    const auto& t = mesh.triangles[k];
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    for (const Vec3& p : {Vec3((a + b + c) / 3), Vec3((a + b) / 2), a}) {
      const float f[3] = {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
      errors.push_back(std::abs(field.value(f)));
    }
  }
  return errors.empty() ? 0 : at_rank(errors, errors.size() * 95 / 100);
}

}  // namespace

ContactShape make_contact_shape(const Mesh& original, const Work& work) {
  ContactShape s;
  const bool round = is_sphere(original) || !make_polytope(original, kFaces).empty();
  const Simplified simple =
      round ? Simplified{original}
            : simplified(original, kSimplify * 2 * std::cbrt(0.75 / std::numbers::pi * mesh_volume(original)),
                         work);
  const Mesh& mesh = simple.mesh;
  for (const auto& v : original.vertices) s.bounding_radius = std::max(s.bounding_radius, v.norm());
  const double r = s.bounding_radius;
  s.gyration = 0.6 * r;
  s.field = DistanceField::of(mesh, kCells, work);
  if (s.field.kind() == DistanceField::Kind::Sphere) {
    const double even = std::cbrt(0.75 / std::numbers::pi * mesh_volume(mesh));
    s.ball = even + kTowardsCorners * (r - even);
  }
  if (s.field.kind() == DistanceField::Kind::Planes) s.polytope = make_polytope(mesh, kFaces);
  s.core = inner_balls(mesh, s.field);
  std::vector<Element> segments;
  if (s.field.kind() ==
      DistanceField::Kind::Planes) {  // vertices are ends of edges, and flat faces touch only those
    for (const auto& [a, b] : convex_edges(mesh, 1e-3))
      segments.push_back(segment_element(mesh.vertices[a], mesh.vertices[b]));
    s.trees[0] = s.trees[1] = s.trees[2] = make_tree(segments);
    s.error = 1e-6 * r;
    return s;
  }
  std::vector<bool> covered(mesh.vertices.size(), false);
  std::vector<Vec3> sharp;
  for (const auto& [a, b] : convex_edges(mesh, 0.5)) {
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b];
    const int pieces = std::max(1, round_up((q - p).norm() / (0.12 * r)));
    for (int k = 0; k < pieces; ++k)
      segments.push_back(segment_element(p + (q - p) * k / pieces, p + (q - p) * (k + 1) / pieces));
    covered[a] = covered[b] = true;
    const int steps = 1 + static_cast<int>((q - p).norm() / (0.01 * r));
    for (int k = 0; k <= steps; ++k) sharp.push_back(p + (q - p) * k / steps);
  }
  s.field.include(sharp);
  if (segments.size() > 1200) {
    segments.clear();
    std::fill(covered.begin(), covered.end(), false);
  }
  const Choice choice = choose_vertices(mesh, r, covered, work);
  std::vector<Element> coarse = segments, fine = segments;
  for (std::size_t k = 0; k < choice.order.size(); ++k) {
    fine.push_back(point_element(mesh.vertices[choice.order[k]]));
    if (k < kCoarse) coarse.push_back(fine.back());
  }
  s.trees[0] = make_tree(std::move(coarse));
  s.trees[1] = make_tree(std::move(fine));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!covered[v]) segments.push_back(point_element(mesh.vertices[v]));
  s.trees[2] = make_tree(std::move(segments));
  s.error = 1e-6 * r;
  // A sphere that encloses its mesh needs no allowance.
  if (s.field.kind() == DistanceField::Kind::Grid)
    s.error += kAllowance * (field_error(mesh, s.field) + 0.5 * choice.missed + simple.deviation);
  return s;
}

}  // namespace terrazzo::packing
