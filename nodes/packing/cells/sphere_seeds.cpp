#include "nodes/packing/cells/sphere_seeds.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/packing/rigid/placement.h"
#include "nodes/packing/rigid/schedule.h"

namespace terrazzo::tessellation {

Seeds sphere_seeds(const Vec3& box, const std::vector<double>& volume, std::uint64_t seed, double fraction,
                   const Work& work) {
  constexpr double kSteps = 600;
  const std::size_t n = volume.size();
  const double total = std::accumulate(volume.begin(), volume.end(), 0.0);
  std::vector<std::size_t> order(n);  // largest first, as placement needs it
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return volume[a] > volume[b]; });

  packing::Packing packed;
  packed.box = box;
  packed.shape.assign(n, 0);
  packed.position.resize(n);
  packed.orientation.assign(n, Quat::Identity());
  std::vector<double> radius;
  for (std::size_t i : order) {
    const double r = std::cbrt(0.75 / std::numbers::pi * volume[i] / total * fraction * box.prod());
    radius.push_back(std::min(r, 0.49 * box.minCoeff()));  // a sphere must fit the box
  }
  packed.scale = radius;
  for (double r : radius) packed.size.push_back(2 * r);
  const std::vector<packing::ContactShape> spheres = {packing::make_contact_shape(geodesic_sphere(3))};
  packing::place_at_random(packed, 0, radius, seed, work.quiet());
  packing::AnnealOptions options;
  options.seed = seed;
  options.enough = 0.9;  // free of overlap is not needed, only an even spread
  packing::Budget budget;
  budget.limit = kSteps;
  packing::pack(spheres, packed, options, budget, work);

  Seeds seeds;
  seeds.box = box;
  seeds.position.resize(n);
  seeds.weight.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    seeds.position[order[k]] = packed.position[k];
    seeds.weight[order[k]] = radius[k] * radius[k];
  }
  return seeds;
}

}  // namespace terrazzo::tessellation
