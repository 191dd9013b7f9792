#include "nodes/common/stereology/shape_measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/depth_areas.h"

namespace terrazzo {
namespace {

struct Candidate {
  Vec3 direction;
  double area;
};

// Upper bound of the section areas across a direction: the area of the shadow, with every fold counted.
class Shadow {
 public:
  explicit Shadow(const Mesh& mesh) {
    normals_.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles) {
      const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
      normals_.push_back((b - a).cross(c - a) / 4);  // half, since a line enters as often as it leaves
    }
  }
  double operator()(const Vec3& direction) const {
    double sum = 0;
    for (const Vec3& n : normals_) sum += std::abs(n.dot(direction));
    return sum * (1 + 1e-9);
  }

 private:
  std::vector<Vec3> normals_;
};

double largest(DepthSweep& sweep, const Vec3& direction) {
  // Skip ranges as thin as rounding errors (a face in the plane). The adjacent ranges reach the same area.
  const auto& ranges = sweep.sweep(direction);
  double extent = 0, best = 0;
  for (const AreaRange& r : ranges) extent += r.thickness;
  for (const AreaRange& r : ranges)
    if (r.thickness > 1e-9 * extent) best = std::max(best, max_area(r));
  return best;
}

// Compass search over tilts of the direction, with the exact depth at each step. The largest section of a
// polyhedron is often on a ridge (through vertices), so each round rotates the compass in order to find the
// direction along the ridge.
Candidate climb(DepthSweep& sweep, const Shadow& shadow, Candidate c, double step, double finest,
                const Work& work) {
  constexpr double kGolden = 2.399963229728653;
  double turn = 0;
  while (step > finest) {
    work.check();
    bool better = false;
    for (int k = 0; k < 6; ++k) {
      const Vec3 a = c.direction.unitOrthogonal(), b = c.direction.cross(a);
      const double angle = turn + k * std::numbers::pi / 3;
      const Vec3 u = (c.direction + step * (std::cos(angle) * a + std::sin(angle) * b)).normalized();
      if (shadow(u) <= c.area) continue;
      const double area = largest(sweep, u);
      if (area > c.area) {
        c = {u, area};
        better = true;
        break;
      }
    }
    turn += kGolden;
    if (!better) step /= 2;
  }
  return c;
}

}  // namespace

double max_section_area(const Mesh& mesh, const Work& work) {
  if (mesh.vertices.empty() || mesh.triangles.empty()) return 0;
  // Meshes with few triangles have sharp peaks; many triangles round them off.
  const bool fine = mesh.triangles.size() > 1000;
  const std::size_t n = fine ? 256 : 800;
  const double finest = fine ? 1e-4 : 2e-6;
  std::vector<Candidate> candidates(n);
  work.part(0, 0.5).parallel(n, n / 8, [&](std::size_t begin, std::size_t end) {
    DepthSweep sweep(mesh);
    for (std::size_t i = begin; i < end; ++i) {
      work.check();
      const Vec3 u = half_sphere_direction(i, n);
      candidates[i] = {u, largest(sweep, u)};
    }
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.area > b.area; });
  // Start from the best candidates in distinct neighborhoods, so that one peak does not take all starts.
  std::vector<Candidate> starts;
  const double apart = std::cos(0.3);
  for (const Candidate& c : candidates) {
    if (starts.size() == (fine ? 3u : 6u)) break;
    const auto near = [&](const Candidate& s) { return std::abs(s.direction.dot(c.direction)) > apart; };
    if (std::none_of(starts.begin(), starts.end(), near)) starts.push_back(c);
  }
  const Shadow shadow(mesh);
  work.part(0.5, 1).parallel(starts.size(), 1, [&](std::size_t begin, std::size_t) {
    DepthSweep sweep(mesh);
    starts[begin] = climb(sweep, shadow, starts[begin], 2 / std::sqrt(static_cast<double>(n)), finest, work);
  });
  double best = 0;
  for (const Candidate& c : starts) best = std::max(best, c.area);
  return best;
}

double quick_max_section_area(const Mesh& mesh) {
  if (mesh.vertices.empty() || mesh.triangles.empty()) return 0;
  const std::size_t directions = mesh.triangles.size() > 500 ? 16 : 80;  // many triangles are rounder
  DepthSweep sweep(mesh);
  const Shadow shadow(mesh);
  // The widest shadows first: once an area exceeds the next shadow, no other direction can exceed it.
  struct Widest {
    double shadow;
    std::size_t index;
  };
  std::vector<Widest> order;
  for (std::size_t i = 0; i < directions; ++i)
    order.push_back({shadow(half_sphere_direction(i, directions)), i});
  std::stable_sort(order.begin(), order.end(),
                   [](const Widest& a, const Widest& b) { return a.shadow > b.shadow; });
  Candidate best{Vec3::UnitZ(), 0};
  for (const Widest& w : order) {
    if (w.shadow <= best.area) break;
    const Vec3 u = half_sphere_direction(w.index, directions);
    if (const double area = largest(sweep, u); area > best.area) best = {u, area};
  }
  return climb(sweep, shadow, best, 0.25, 0.04, {}).area;
}

Shape measure_shape(std::string name, Mesh mesh, double probability, const Work& work) {
  if (const auto faults = mesh_faults(mesh); !faults.empty()) {
    std::string text;
    for (const auto& f : faults) text += (text.empty() ? "" : "; ") + f;
    throw Error("open-mesh", fmt::format("the surface of \"{}\" is not closed: {}", name, text),
                "close the holes and make all triangles face outward");
  }
  Shape shape;
  shape.name = std::move(name);
  shape.probability = probability;
  shape.volume = mesh_volume(mesh);
  const double radius = mesh_bounding_radius(mesh, mesh.vertices[mesh.triangles[0][0]]);
  if (!(shape.volume > 1e-12 * radius * radius * radius))
    throw Error(
        "no-volume", fmt::format("\"{}\" has a volume of {:.4g} mm³", shape.name, shape.volume),
        shape.volume < 0 ? "flip all triangles" : "use a mesh with an extent in all three directions");
  transform(mesh, Mat3::Identity(), -mesh_centroid(mesh));
  shape.surface_area = mesh_surface_area(mesh);
  shape.mean_caliper = mesh_mean_caliper(mesh);
  shape.max_section_area = max_section_area(mesh, work);
  shape.mesh = std::move(mesh);
  return shape;
}

void normalize_probabilities(Shapes& shapes) {
  double sum = 0;
  for (const Shape& s : shapes.shapes) {
    if (!(s.probability >= 0) || !std::isfinite(s.probability))
      throw Error("bad-probabilities",
                  fmt::format("\"{}\" has the invalid probability {}", s.name, s.probability),
                  "set the probability of each shape to zero or more");
    sum += s.probability;
  }
  if (!(sum > 0))
    throw Error("bad-probabilities", "the probabilities of all shapes are zero",
                "make at least one positive");
  for (Shape& s : shapes.shapes) s.probability /= sum;
}

}  // namespace terrazzo
