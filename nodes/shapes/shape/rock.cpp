#include "nodes/shapes/shape/rock.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/mesh/convex_polyhedron.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::shape {

namespace {

// Random streams of one rock.
enum RockStream : std::uint64_t { kProportions = 101, kFacets, kChips, kHollows, kField };

// Shorter edges, relative to the radius, create slivers that look like defects and slow down contact tests.
constexpr double kShortestEdge = 0.06;

// Adds the half-space if it leaves a polyhedron without slivers.
bool cut(std::vector<HalfSpace>& planes, const HalfSpace& h) {
  planes.push_back(h);
  const auto p = intersect(planes);
  if (p.shortest_edge() >= kShortestEdge && !p.faces.back().empty()) return true;
  planes.pop_back();
  return false;
}

ConvexPolyhedron fractured(const RockOptions& o, const Work& work) {
  Random r(o.seed, kFacets, o.item);
  // The tetrahedron bounds the body until there are enough facets.
  std::vector<HalfSpace> planes;
  const Quat q(Eigen::AngleAxisd(r.uniform(0, 2 * std::numbers::pi), random_direction(r)));
  for (const Vec3& n : {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)}) {
    const Vec3 m = (q * n.normalized() + 0.35 * random_direction(r)).normalized();
    planes.push_back({m, r.uniform(0.62, 0.9)});
  }
  // Directions keep a minimum angle, smaller for more facets, so that faces stay large.
  double apart = std::sqrt(4 * std::numbers::pi / o.facets) * 0.75;
  for (int tries = 0; count_of(planes) < o.facets && tries < 400; ++tries) {
    work.check();
    const Vec3 n = random_direction(r);
    const double offset = r.uniform(0.62, 0.95);
    if (tries % 40 == 39) apart *= 0.85;
    const auto near = [&](const HalfSpace& h) {
      return std::acos(std::clamp(h.normal.dot(n), -1.0, 1.0)) < apart;
    };
    if (std::none_of(planes.begin(), planes.end(), near)) cut(planes, {n, offset});
  }
  // Cut off corners far outside the sphere, then random corners.
  Random c(o.seed, kChips, o.item);
  int chipped = 0;
  for (int tries = 0; tries < 60 + 4 * o.chips; ++tries) {
    work.check();
    const auto p = intersect(planes);
    const auto far = std::max_element(p.corners.begin(), p.corners.end(),
                                      [](const Vec3& a, const Vec3& b) { return a.norm() < b.norm(); });
    if (far->norm() > 1.15 && tries < 60) {
      const Vec3 n = (far->normalized() + 0.3 * random_direction(c)).normalized();
      if (cut(planes, {n, n.dot(*far) - c.uniform(0.3, 0.9) * (far->norm() - 0.95)})) continue;
    }
    if (chipped >= o.chips) {
      if (far->norm() <= 1.15 || tries >= 60) break;
      continue;
    }
    const Vec3 corner = p.corners[c.below(p.corners.size())];
    const Vec3 n = (corner.normalized() + 0.5 * random_direction(c)).normalized();
    if (cut(planes, {n, n.dot(corner) - c.uniform(0.03, 0.14)})) ++chipped;
  }
  return intersect(planes);
}

// Splits the longest edge in both its triangles until none is longer than `limit`.
void split_long_edges(Mesh& mesh, double limit, const Work& work) {
  for (;;) {
    work.check();
    std::map<std::pair<int, int>, int> midpoint;
    // An edge is split in this round if it is the longest of both its triangles: a conforming bisection.
    auto longest = [&](const Triangle& t) {
      int best = 0;
      double length = -1;
      for (int k = 0; k < 3; ++k) {
        const double l = (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).squaredNorm();
        const auto key = std::minmax(t[k], t[(k + 1) % 3]), old = std::minmax(t[best], t[(best + 1) % 3]);
        if (l > length || (l == length && key < old)) {
          best = k;
          length = l;
        }
      }
      return best;
    };
    std::map<std::pair<int, int>, int> votes;
    for (const auto& t : mesh.triangles) {
      const int k = longest(t);
      if ((mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm() > limit)
        ++votes[std::minmax(t[k], t[(k + 1) % 3])];
    }
    if (votes.empty()) return;
    for (const auto& [edge, n] : votes)
      if (n == 2) {
        midpoint[edge] = mesh.vertices.size();
        mesh.vertices.push_back((mesh.vertices[edge.first] + mesh.vertices[edge.second]) / 2);
      }
    const std::size_t count = mesh.triangles.size();
    for (std::size_t i = 0; i < count; ++i) {
      const auto t = mesh.triangles[i];
      for (int k = 0; k < 3; ++k) {
        const auto found = midpoint.find(std::minmax(t[k], t[(k + 1) % 3]));
        if (found == midpoint.end()) continue;
        mesh.triangles[i] = {t[k], found->second, t[(k + 2) % 3]};
        mesh.triangles.push_back({found->second, t[(k + 1) % 3], t[(k + 2) % 3]});
        break;
      }
    }
  }
}

// Conchoidal chips: spheres at edges whose interior is removed. Points inside move to where their ray from
// the center enters the sphere.
void hollow(Mesh& mesh, const ConvexPolyhedron& body, const RockOptions& o) {
  Random r(o.seed, kHollows, o.item);
  for (int i = 0; i < (o.chips + 1) / 2; ++i) {
    const auto& face = body.faces[r.below(body.faces.size())];
    if (face.empty()) continue;
    const std::size_t k = r.below(face.size());
    const double t = r.uniform(0.25, 0.75);
    const Vec3 at = (1 - t) * body.corners[face[k]] + t * body.corners[face[(k + 1) % face.size()]];
    const double radius = r.uniform(0.25, 0.5), depth = r.uniform(0.04, 0.1);
    const Vec3 center = at + at.normalized() * (radius - depth);
    for (auto& v : mesh.vertices) {
      const Vec3 u = v.normalized();
      const double along = u.dot(center), gap = center.squaredNorm() - along * along;
      if (gap >= radius * radius) continue;
      const double enter = along - std::sqrt(radius * radius - gap);
      if (enter > 0 && enter < v.norm()) v = u * enter;
    }
  }
}

void roughen(Mesh& mesh, const RockOptions& o) {
  constexpr int kWaves = 24;
  Random r(o.seed, kField, o.item);
  std::array<Vec3, kWaves> wave;
  std::array<double, kWaves> phase, weight;
  double power = 0;
  for (int i = 0; i < kWaves; ++i) {
    const double length = r.uniform(0.25, 1.2);  // relative to the radius
    wave[i] = random_direction(r) * (2 * std::numbers::pi / length);
    phase[i] = r.uniform(0, 2 * std::numbers::pi);
    weight[i] = length;
    power += length * length / 2;
  }
  for (auto& v : mesh.vertices) {
    double f = 0;
    for (int i = 0; i < kWaves; ++i) f += weight[i] * std::cos(wave[i].dot(v) + phase[i]);
    v *= std::max(0.3, 1 + o.roughness * f / std::sqrt(power));
  }
}

}  // namespace

Mesh rock_mesh(const RockOptions& o, const Work& work) {
  const auto body = fractured(o, work);
  Mesh mesh = triangulate(body);
  // Edge length of equilateral triangles that tile the unit sphere; bisection leaves edges at about
  // 0.7 of the limit.
  split_long_edges(mesh, std::sqrt(4 * std::numbers::pi / (60 << o.detail) * 4 / std::sqrt(3.0)) * 1.35,
                   work);
  hollow(mesh, body, o);
  roughen(mesh, o);
  Random r(o.seed, kProportions, o.item);
  for (int k = 0; k < 3; ++k) {
    const double s = o.axes[k] * r.uniform(0.75, 1.1);
    for (auto& v : mesh.vertices) v[k] *= s;
  }
  return mesh;
}

}  // namespace terrazzo::shape
