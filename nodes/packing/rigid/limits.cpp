#include "nodes/packing/rigid/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/packing/rigid/contact/distance_field.h"

namespace terrazzo::packing {
namespace {

// Radius of the ball about the centroid inside each used shape; −1 for others.
std::vector<double> inner_radii(const Shapes& shapes, const std::vector<std::int32_t>& used) {
  std::vector<double> radius(shapes.shapes.size(), -1);
  for (std::int32_t s : used)
    if (radius[s] < 0)
      radius[s] = std::max(0.0, -MeshDistance(shapes.shapes[s].mesh).signed_distance(Vec3::Zero()));
  return radius;
}

}  // namespace

double memory_needed(const Population& population, const Shapes& shapes) {
  std::vector<bool> round;
  for (const auto& s : shapes.shapes) round.push_back(is_sphere(s.mesh));
  double bytes = 0;
  for (std::int32_t s : population.particles.shape) bytes += round[s] ? 1500 : 5000;
  return bytes;
}

void refuse_impossible_density(const Population& population, const Shapes& shapes, double binder_gap) {
  const Particles& p = population.particles;
  const auto inner = inner_radii(shapes, p.shape);
  std::vector<double> radius(p.count());
  for (std::size_t i = 0; i < p.count(); ++i) radius[i] = inner[p.shape[i]] * p.scale[i] + 0.5 * binder_gap;
  std::sort(radius.rbegin(), radius.rend());
  const double densest = std::numbers::pi / std::sqrt(18.0);
  double worst = 0;
  // The k + 1 largest, as balls of the size of the smallest of them.
  for (std::size_t k = 0; k < radius.size(); ++k) worst = std::max(worst, (k + 1) * std::pow(radius[k], 3));
  worst *= 4.0 / 3 * std::numbers::pi / p.box.prod();
  if (worst > densest)
    throw Error("impossible-density",
                fmt::format("the {} particles cannot fill {:.3f} of the box{}: their inscribed balls would "
                            "fill {:.3f} of it, but balls of one size fill at most {:.4f}",
                            p.count(), population.fraction,
                            binder_gap > 0 ? fmt::format(" with a binder gap of {} mm", binder_gap) : "",
                            worst, densest),
                "lower the volume fraction or binder_gap");
}

void refuse_what_memory_cannot_hold(const Population& population, const Shapes& shapes,
                                    std::uint64_t available) {
  const double needed = memory_needed(population, shapes);
  if (needed > 0.9 * available)
    throw Error("not-enough-memory",
                fmt::format("packing {} particles needs about {:.1f} GB of memory; {:.1f} GB are free",
                            population.particles.count(), needed / 1e9, available / 1e9),
                "make the box smaller, or leave out the smallest classes")
        .parameter("size");
}

}  // namespace terrazzo::packing
