#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/convex_polyhedron.h"
#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/methods/refine.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {
namespace {

constexpr std::uint64_t kFractureStream = 0x66726163;
constexpr double kRadiansPerDegree = std::numbers::pi / 180;
constexpr double kUpright = std::numbers::pi / 2;

// The convex polygon with as few corners as show the outline's form.
Loop sides_of(const Outline& o) {
  constexpr double kLeast = 0.02;  // of the area: what a corner adds; those of pixels add less
  Loop loop = hull_of(o.points);
  const auto adds = [&](std::size_t i) {
    const Vec2 &a = loop[(i + loop.size() - 1) % loop.size()], &b = loop[i], &c = loop[(i + 1) % loop.size()];
    return cross(b - a, c - b) / 2;
  };
  while (loop.size() > 3) {
    std::size_t least = 0;
    for (std::size_t i = 1; i < loop.size(); ++i)
      if (adds(i) < adds(least)) least = i;
    if (adds(least) >= kLeast * o.area) break;
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(least));
  }
  return loop;
}

// Planes of fracture: an upright one, or two that meet at an obtuse angle, at each side of the outline; above
// and below, a flat one, or two or three that meet near the middle. `half`: of the height, mm.
std::vector<HalfSpace> fractures(const Loop& sides, double half, Random random) {
  constexpr double kSharpest = 90 * kRadiansPerDegree, kBluntest = 135 * kRadiansPerDegree;
  constexpr double kFlattest = 30 * kRadiansPerDegree;  // of a face, from the picture's plane
  constexpr double kSteep = 15 * kRadiansPerDegree;     // of a face alone, from upright
  constexpr double kHigh = 0.35;                        // of sides above the middle, in half the height
  constexpr double kAlone = 0.5;                        // share of the sides with one face
  std::vector<HalfSpace> faces;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Vec2 along = (sides[(i + 1) % sides.size()] - sides[i]).normalized();
    const Vec2 out(along.y(), -along.x());
    const Vec3 at(sides[i].x(), sides[i].y(), half * random.uniform(-kHigh, kHigh));
    const auto add = [&](double elevation) {  // of the normal
      const Vec3 normal(out.x() * std::cos(elevation), out.y() * std::cos(elevation), std::sin(elevation));
      faces.push_back({normal, normal.dot(at)});
    };
    if (random.uniform() < kAlone) {
      add(random.uniform(-kSteep, kSteep));
      continue;
    }
    const double between = random.uniform(kSharpest, kBluntest);
    const double upper =
        random.uniform(std::max(kFlattest, between - kUpright), std::min(kUpright, between - kFlattest));
    add(kUpright - upper);
    add(between - upper - kUpright);
  }
  for (const double side : {1.0, -1.0}) {
    const int count = 1 + static_cast<int>(random.below(3));
    const double start = random.uniform(0, 2 * std::numbers::pi);
    const double high = half * random.uniform(0.75, 1);
    for (int k = 0; k < count; ++k) {
      const double tilt = (count == 1 ? random.uniform(0, 20) : random.uniform(20, 45)) * kRadiansPerDegree;
      const double azimuth = start + (k + random.uniform(-0.2, 0.2)) * 2 * std::numbers::pi / count;
      const Vec3 normal(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                        side * std::cos(tilt));
      faces.push_back({normal, high * std::cos(tilt)});
    }
  }
  return faces;
}

void give_silhouette_area(Mesh& mesh, double area) {
  Loop shadow;
  for (const Vec3& v : mesh.vertices) shadow.emplace_back(v.head<2>());
  transform(mesh, std::sqrt(area / hull_area(std::move(shadow))) * Mat3::Identity(), Vec3::Zero());
}

}  // namespace

Estimate faceted(const EstimateRequest& request, const Work& work) {
  constexpr std::uint64_t kTries = 100;
  constexpr double kShortest = 1e-3;  // edge of a polyhedron, in half the height
  constexpr double kFine = 0.28;      // longest edge of a triangle without subdivision, in half the height
  constexpr int kWear = 1;            // rounds of smoothing, which rounds edges by about a triangle
  const Outline& o = request.chosen[0];
  const Loop sides = sides_of(o);
  const double half = std::sqrt(o.area * o.aspect / std::numbers::pi);
  for (std::uint64_t k = 0; k < kTries; ++k) {
    work.check();
    const Random random(request.seed, kFractureStream, request.index * kTries + k);
    const ConvexPolyhedron body = intersect(fractures(sides, half, random));
    if (!(body.shortest_edge() > kShortest * half)) continue;
    Estimate out;
    out.mesh = triangulate(body);
    if (!mesh_faults(out.mesh).empty()) continue;
    split_edges(out.mesh, std::ldexp(kFine * half, -request.subdivision));
    out.mesh.vertices = smoothed(out.mesh, kWear);
    give_silhouette_area(out.mesh, o.area);
    return out;
  }
  throw Error("no-intersection",
              fmt::format("no planes of fracture enclose a body with the outline of profile {}", o.id),
              "set method to inflation, or choose other profiles")
      .parameter("method");
}

}  // namespace terrazzo::shape_estimate
