#include "nodes/packing/rigid/audit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "nodes/common/geometry/mesh/aabb_tree.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/packing/rigid/contact/triangle_overlap.h"

namespace terrazzo::packing {

struct Auditor::Solid {
  const Mesh* mesh;
  AabbTree tree;
  MeshDistance distance;
  double radius = 0;
  Eigen::Array<double, Eigen::Dynamic, 3> points;  // the vertices
  explicit Solid(const Mesh& m) : mesh(&m), tree(m, 2), distance(m), points(m.vertices.size(), 3) {
    for (std::size_t v = 0; v < m.vertices.size(); ++v) {
      radius = std::max(radius, m.vertices[v].norm());
      points.row(v) = m.vertices[v].transpose();
    }
  }
  // Largest extent of the mesh along n.
  double reach(const Vec3& n) const {
    return (points.col(0) * n[0] + points.col(1) * n[1] + points.col(2) * n[2]).maxCoeff();
  }
};

namespace {

using Solid = Auditor::Solid;

// Work of the calling thread, in samples of a distance field; the factors are measured times.
thread_local std::size_t tests = 0;
constexpr std::size_t kBoxes = 2, kTriangles = 20, kDistance = 60;

// b's frame relative to a's, both unscaled: p ↦ linear p + offset.
struct Map {
  Mat3 linear;
  Vec3 offset;
  Vec3 operator()(const Vec3& p) const { return linear * p + offset; }
};

bool boxes_meet(const Aabb& a, const Aabb& b, const Map& b_to_a, const Mat3& magnitude) {
  const Vec3 half = magnitude * (0.5 * (b.high - b.low));
  const Vec3 center = b_to_a(b.center());
  return ((center - half).array() <= a.high.array()).all() &&
         ((center + half).array() >= a.low.array()).all();
}

Corners corners(const Mesh& mesh, int t) {
  const auto& tri = mesh.triangles[t];
  return {mesh.vertices[tri[0]], mesh.vertices[tri[1]], mesh.vertices[tri[2]]};
}

// Continues with the halves of the larger of two boxes. `scale` is b's unit in a's.
void descend(const Solid& a, const Solid& b, int i, int j, double scale,
             std::vector<std::pair<int, int>>& stack) {
  const auto &m = a.tree.nodes[i], &n = b.tree.nodes[j];
  const bool split_a =
      n.right == 0 || (m.right != 0 && (m.box.high - m.box.low).squaredNorm() >=
                                           (n.box.high - n.box.low).squaredNorm() * scale * scale);
  if (split_a)
    stack.insert(stack.end(), {{m.right, j}, {i + 1, j}});
  else
    stack.insert(stack.end(), {{i, n.right}, {i, j + 1}});
}

// Visits the pairs of triangles, in a's unit, that are in boxes which are not `apart`.
template <class Apart, class Visit>
void each_pair(const Solid& a, const Solid& b, const Map& b_to_a, const Apart& apart, const Visit& visit) {
  const double scale = b_to_a.linear.col(0).norm();
  std::vector<std::pair<int, int>> stack{{0, 0}};
  while (!stack.empty()) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    const auto &m = a.tree.nodes[i], &n = b.tree.nodes[j];
    tests += kBoxes;
    if (apart(m.box, n.box)) continue;
    if (m.right != 0 || n.right != 0) {
      descend(a, b, i, j, scale, stack);
      continue;
    }
    for (int y = n.first; y < n.first + n.count; ++y) {
      Corners cb = corners(*b.mesh, b.tree.triangles[y]);
      for (auto& p : cb) p = b_to_a(p);
      tests += kTriangles * m.count;
      for (int x = m.first; x < m.first + m.count; ++x) visit(corners(*a.mesh, a.tree.triangles[x]), cb);
    }
  }
}

// Depth of the deepest intersection of triangles in a's unit; 0 if some only touch, −1 if none meet.
double crossing(const Solid& a, const Solid& b, const Map& b_to_a) {
  const Mat3 magnitude = b_to_a.linear.cwiseAbs();
  double deepest = -1;
  each_pair(
      a, b, b_to_a, [&](const Aabb& m, const Aabb& n) { return !boxes_meet(m, n, b_to_a, magnitude); },
      [&](const Corners& ca, const Corners& cb) {
        deepest = std::max(deepest, triangle_penetration(ca, cb));
      });
  return deepest;
}

// Smallest distance of two surfaces that do not intersect, in a's unit, or `bound` if that is smaller.
double clearance(const Solid& a, const Solid& b, const Map& b_to_a, double bound) {
  const Mat3 magnitude = b_to_a.linear.cwiseAbs();
  const auto box_distance = [&](const Aabb& m, const Aabb& n) {
    const Vec3 half = magnitude * (0.5 * (n.high - n.low)), center = b_to_a(n.center());
    return (m.low - (center + half)).cwiseMax((center - half) - m.high).cwiseMax(Vec3::Zero()).norm();
  };
  each_pair(
      a, b, b_to_a, [&](const Aabb& m, const Aabb& n) { return box_distance(m, n) >= bound; },
      [&](const Corners& ca, const Corners& cb) { bound = std::min(bound, triangle_distance(ca, cb)); });
  return bound;
}

// Largest depth of `own`'s vertices and triangle centers inside `other`, in other's unit, at least `least`.
// Skips boxes of triangles that cannot contain a deeper point than those found before.
double deepest_point(const Solid& own, const Solid& other, const Map& own_to_other, double least = 0) {
  double deepest = least;
  const Aabb& box = other.tree.nodes[0].box;
  const double scale = own_to_other.linear.col(0).norm();
  const auto probe = [&](const Vec3& v) {
    const Vec3 p = own_to_other(v);
    tests += kDistance;
    if (box.squared_distance(p) == 0) deepest = std::max(deepest, -other.distance.signed_distance(p));
  };
  std::vector<int> stack{0};
  while (!stack.empty()) {
    const int k = stack.back();
    stack.pop_back();
    const auto& node = own.tree.nodes[k];
    const double radius = 0.5 * (node.box.high - node.box.low).norm() * scale;
    const Vec3 center = own_to_other(node.box.center());
    if (box.squared_distance(center) > radius * radius) continue;
    tests += kDistance;
    if (radius - other.distance.signed_distance(center) <= deepest) continue;
    if (node.right != 0) {
      stack.insert(stack.end(), {node.right, k + 1});
      continue;
    }
    for (int m = node.first; m < node.first + node.count; ++m) {
      const Corners c = corners(*own.mesh, own.tree.triangles[m]);
      for (const auto& v : c) probe(v);
      probe((c[0] + c[1] + c[2]) / 3);
    }
  }
  return deepest;
}

double depth_of_pair(const Solid& a, double scale_a, const Mat3& rotation_a, const Solid& b, double scale_b,
                     const Mat3& rotation_b, const Vec3& offset, double gap) {
  tests += static_cast<std::size_t>(a.points.rows() + b.points.rows()) / 8;
  // Most neighbors are separated by a plane perpendicular to the line between their centers.
  if (const double distance = offset.norm(); distance > 0) {
    const Vec3 n = offset / distance;
    if (distance - a.reach(rotation_a.transpose() * n) * scale_a -
            b.reach(rotation_b.transpose() * -n) * scale_b >=
        gap)
      return 0;
  }
  const Map b_to_a{rotation_a.transpose() * rotation_b * (scale_b / scale_a),
                   rotation_a.transpose() * offset / scale_a};
  const Map a_to_b{rotation_b.transpose() * rotation_a * (scale_a / scale_b),
                   rotation_b.transpose() * -offset / scale_b};
  const double crossed = crossing(a, b, b_to_a) * scale_a;
  if (crossed >= 0)  // faces that only touch may still belong to overlapping bodies if they are coplanar
  {
    const double depth = deepest_point(a, b, a_to_b, crossed / scale_b) * scale_b;
    return gap + deepest_point(b, a, b_to_a, depth / scale_a) * scale_a;
  }
  // The surfaces do not intersect, but one body may be entirely inside the other.
  const auto inside = [](const Solid& outer, const Vec3& p) {
    return outer.tree.nodes[0].box.squared_distance(p) == 0 && outer.distance.signed_distance(p) < 0;
  };
  if (inside(b, a_to_b(a.mesh->vertices[a.mesh->triangles[0][0]])))
    return gap + deepest_point(a, b, a_to_b) * scale_b;
  if (inside(a, b_to_a(b.mesh->vertices[b.mesh->triangles[0][0]])))
    return gap + deepest_point(b, a, b_to_a) * scale_a;
  if (!(gap > 0)) return 0;
  const double bound = gap / scale_a, distance = clearance(a, b, b_to_a, bound);
  return distance < bound ? gap - distance * scale_a : 0;
}

// Which particles may meet.
class NearParticles {
 public:
  NearParticles(const Particles& particles, const std::vector<double>& reach)
      : particles_(particles),
        reach_(reach),
        cells_(particles.box, 2 * std::accumulate(reach.begin(), reach.end(), 0.0) / reach.size(), 128),
        in_cell_(cells_.count()) {
    // A particle is listed in every cell that the cube around it touches.
    for (std::size_t i = 0; i < reach.size(); ++i)
      cells_.visit(particles.position[i], reach[i], [&](std::size_t c) { in_cell_[c].push_back(i); });
  }

  // Those that may meet particle i, from i on.
  void find(std::int32_t i, std::vector<std::int32_t>& near) const {
    near.clear();
    cells_.visit(particles_.position[i], reach_[i], [&](std::size_t c) {
      for (std::int32_t j : in_cell_[c])
        if (j >= i) near.push_back(j);
    });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
  }

 private:
  const Particles& particles_;
  const std::vector<double>& reach_;
  PeriodicCells cells_;
  std::vector<std::vector<std::int32_t>> in_cell_;
};

// Calls test(offset of j from i) for each image of j that i may meet.
template <class Test>
void each_image(const Particles& particles, std::int32_t i, std::int32_t j, double reach, Test&& test) {
  // Centers are inside the box and bounding spheres fit into it, so only the 27 nearest images can meet.
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        if (i == j && (z < 0 || (z == 0 && (y < 0 || (y == 0 && x <= 0))))) continue;
        const Vec3 offset =
            particles.position[j] - particles.position[i] + Vec3(x, y, z).cwiseProduct(particles.box);
        if (offset.norm() >= reach) continue;
        test(offset);
      }
}

bool same_place(const Particles& a, const Particles& b, std::size_t i) {
  return a.shape[i] == b.shape[i] && a.scale[i] == b.scale[i] && a.position[i] == b.position[i] &&
         a.orientation[i].coeffs() == b.orientation[i].coeffs();
}

// The depth of a pair in an earlier result, 0 if it did not meet.
double depth_found(const std::vector<Penetration>& found, std::int32_t i, std::int32_t j) {
  const auto at =
      std::lower_bound(found.begin(), found.end(), std::pair(i, j),
                       [](const Penetration& p, const std::pair<std::int32_t, std::int32_t>& key) {
                         return std::pair(p.a, p.b) < key;
                       });
  return at != found.end() && at->a == i && at->b == j ? at->depth : 0.0;
}

}  // namespace

Auditor::Auditor(const Shapes& shapes) : shapes_(shapes), solids_(shapes.shapes.size()) {}
Auditor::~Auditor() = default;

AuditResult Auditor::operator()(const Particles& particles, double gap, const Work& work) {
  AuditResult result;
  const std::size_t n = particles.count();
  if (n == 0) return result;
  auto& solids = solids_;
  for (std::int32_t s : particles.shape)
    if (!solids[s]) solids[s] = std::make_unique<Solid>(shapes_.shapes[s].mesh);
  std::vector<double> reach(n);
  std::vector<Mat3> rotation(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double radius = solids[particles.shape[i]]->radius * particles.scale[i];
    reach[i] = radius + 0.5 * gap;
    rotation[i] = particles.orientation[i].toRotationMatrix();
  }
  const NearParticles neighbors(particles, reach);
  // Pairs of which neither particle has moved since the last audit still have the depth found then.
  const bool again = last_.count() == n && last_.box == particles.box && last_gap_ == gap;
  std::vector<std::uint8_t> moved(n, 1);
  for (std::size_t i = 0; again && i < n; ++i) moved[i] = !same_place(last_, particles, i);

  constexpr std::size_t kGrain = 32;
  std::vector<AuditResult> parts((n + kGrain - 1) / kGrain);
  work.parallel(n, kGrain, [&](std::size_t begin, std::size_t end) {
    AuditResult& part = parts[begin / kGrain];
    std::vector<std::int32_t> near;
    tests = 0;
    for (std::size_t s = begin; s < end; ++s) {
      work.check();
      const std::int32_t i = s;
      neighbors.find(i, near);
      for (std::int32_t j : near) {
        const bool known = !moved[i] && !moved[j];
        double depth = known ? depth_found(last_found_, i, j) : 0;
        each_image(particles, i, j, reach[i] + reach[j], [&](const Vec3& offset) {
          ++part.pairs;
          if (known) return;
          depth = std::max(depth, depth_of_pair(*solids[particles.shape[i]], particles.scale[i], rotation[i],
                                                *solids[particles.shape[j]], particles.scale[j], rotation[j],
                                                offset, gap));
        });
        if (depth > 0)
          part.found.push_back({i, j, depth, depth / std::min(particles.size[i], particles.size[j])});
      }
    }
    part.tests = tests / 6;
  });
  for (const AuditResult& part : parts) {
    result.found.insert(result.found.end(), part.found.begin(), part.found.end());
    result.pairs += part.pairs;
    result.tests += part.tests;
  }
  last_ = particles;
  last_gap_ = gap;
  last_found_ = result.found;
  for (const auto& p : result.found) result.worst = std::max(result.worst, p.relative);
  return result;
}

AuditResult audit(const Shapes& shapes, const Particles& particles, double gap, const Work& work) {
  return Auditor(shapes)(particles, gap, work);
}

}  // namespace terrazzo::packing
