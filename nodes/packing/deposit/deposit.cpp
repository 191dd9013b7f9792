#include "nodes/packing/deposit/deposit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/packing/deposit/falling.h"
#include "nodes/packing/rigid/packer.h"
#include "nodes/packing/rigid/placement.h"
#include "nodes/packing/rigid/statistics.h"

namespace terrazzo::packing {
namespace {

// Share of the space above the floor that the balls around the stones fill at first, so loosely that they
// overlap little.
constexpr double kScattered = 0.3;
constexpr int kMostSteps = 3000;
constexpr double kSlow = 0.2;  // speed below which the stones are calmed
constexpr double kAtRest = 0.05, kFalling = 1;
constexpr std::size_t kMostFalling = 50'000;  // for minutes, not hours
constexpr int kFewestSteps = 100;             // stones gather speed first

std::vector<std::optional<FallingShape>> shapes_of(const Shapes& shapes, const Particles& particles,
                                                   const Work& work) {
  std::vector<std::optional<FallingShape>> falling(shapes.shapes.size());
  for (const std::int32_t s : particles.shape) {
    if (falling[s]) continue;
    work.check();
    falling[s].emplace(shapes.shapes[s].mesh);
  }
  return falling;
}

// Scatters the stones above the floor. Their box becomes as high as that needs.
Packing scattered(const Particles& particles, const std::vector<std::optional<FallingShape>>& falling,
                  std::uint64_t seed, const Work& work) {
  Packing packing = packing_of(particles);
  std::vector<double> radius;
  double volume = 0, largest = 0;
  for (std::size_t i = 0; i < packing.count(); ++i) {
    radius.push_back(falling[packing.shape[i]]->reach * packing.scale[i]);
    volume += 4 / 3.0 * std::numbers::pi * std::pow(radius[i], 3);
    largest = std::max(largest, radius[i]);
  }
  packing.box.z() = std::max(volume / kScattered / (packing.box.x() * packing.box.y()), 2 * largest);
  place_at_random(packing, 0, radius, seed, work);
  for (Vec3& p : packing.position) p.z() += largest;
  return packing;
}

double usual_size(const Particles& particles) {
  double cubes = 0;
  for (const double size : particles.size) cubes += std::pow(size, 3);
  return std::cbrt(cubes / static_cast<double>(particles.count()));
}

// Returns the number of steps.
int fall(FallingBodies& bodies, const Work& work) {
  constexpr int kUsualSteps = 400;
  int step = 0;
  double speed = 0;
  for (bool calm = false; step < kMostSteps; ++step) {
    work.progress(1 - std::exp2(-3.0 * step / kUsualSteps), fmt::format("speed {:.2g}", speed));
    bodies.step(work);
    speed = bodies.speed();
    if (!std::isfinite(speed))
      throw Error("bad-number", "the stones fall with speeds that are not finite", "use other shapes");
    if (step < kFewestSteps) continue;
    if (speed < kAtRest && bodies.fastest() < kFalling) break;
    if (!calm && speed < kSlow) {
      calm = true;
      bodies.calm();
    }
  }
  return step;
}

// Moves the particles up or down so that the box begins at the lowest one and ends with the highest one.
void fit_height(Particles& p, const Shapes& shapes, const Work& work) {
  double low = 1e300, high = -1e300;
  for (std::size_t i = 0; i < p.count(); ++i) {
    if (i % 64 == 0) work.check();
    const auto [below, above] = height_range(shapes, p, i);
    low = std::min(low, below);
    high = std::max(high, above);
  }
  // Sixty-fourths of the longest edge, so that whole voxels fill the box at usual resolutions.
  const double unit = std::max(p.box.x(), p.box.y()) / 64;
  p.box.z() = unit * std::ceil((high - low) / unit + 1e-6);
  for (Vec3& at : p.position) at.z() -= low;
}

}  // namespace

PackResult deposit_particles(const SizeDistribution& distribution, const Shapes& shapes,
                             const PopulationOptions& options, const Work& work) {
  const Population population = populate(distribution, shapes, nullptr, options, work.quiet());
  PackResult result;
  result.particles = population.particles;
  set_request(result, population);
  Particles& particles = result.particles;
  if (particles.count() == 0) return result;
  if (particles.count() > kMostFalling)
    throw Error("too-many-particles",
                fmt::format("{} stones would fall; the limit is {}", particles.count(), kMostFalling),
                "lower `count`, or make the box smaller");
  const auto falling = shapes_of(shapes, particles, work);
  const Packing start = scattered(particles, falling, options.seed, work.part(0, 0.05));
  FallingBodies bodies(particles.box.head<2>(), usual_size(particles));
  for (std::size_t i = 0; i < start.count(); ++i) {
    if (i % 64 == 0) work.check();
    bodies.add(*falling[start.shape[i]], start.scale[i], start.position[i], start.orientation[i]);
  }
  result.iterations = fall(bodies, work.part(0.05, 1));
  if (result.iterations == kMostSteps)
    result.notes.push_back("some stones still move: the bed has not come to rest");
  for (std::size_t i = 0; i < start.count(); ++i) {
    particles.position[i] = bodies.position(i);
    particles.orientation[i] = bodies.orientation(i);
  }
  fit_height(particles, shapes, work);
  return result;
}

}  // namespace terrazzo::packing
