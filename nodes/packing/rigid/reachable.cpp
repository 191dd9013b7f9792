#include "nodes/packing/rigid/reachable.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "nodes/packing/rigid/placement.h"

namespace terrazzo::packing {
namespace {

constexpr std::size_t kSample = 200;
constexpr double kEasyBalls = 0.58;  // volume fraction that balls of any sizes reach in a few hundred steps

double volume_of(const Particles& p, const Shapes& shapes, std::size_t i) {
  return shapes.shapes[p.shape[i]].volume * std::pow(p.scale[i], 3);
}

// Particle indices by decreasing volume.
std::vector<std::size_t> by_volume(const Particles& p, const Shapes& shapes) {
  std::vector<double> volume(p.count());
  for (std::size_t i = 0; i < volume.size(); ++i) volume[i] = volume_of(p, shapes, i);
  std::vector<std::size_t> order(p.count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return volume[a] > volume[b]; });
  return order;
}

}  // namespace

double surely_reachable(const Population& population, const Shapes& shapes,
                        const std::vector<ContactShape>& contact_shapes, double binder_gap) {
  const Particles& p = population.particles;
  double filled = 0, balls = 0;
  for (std::size_t i = 0; i < p.count(); ++i) {
    filled += volume_of(p, shapes, i);
    balls += 4.0 / 3 * std::numbers::pi *
             std::pow(contact_shapes[p.shape[i]].bounding_radius * p.scale[i] + 0.5 * binder_gap, 3);
  }
  return balls > 0 ? kEasyBalls * filled / balls : 0;
}

Reachable try_sample(const Population& population, const Shapes& shapes,
                     const std::vector<ContactShape>& contact_shapes, const AnnealOptions& options,
                     const Work& work) {
  const Particles& p = population.particles;
  const std::size_t n = p.count();
  if (n < 3 * kSample) return {};
  const auto order = by_volume(p, shapes);
  double diameter = 0;
  for (std::size_t i = 0; i < n; ++i)
    diameter = std::max(diameter, 2 * contact_shapes[p.shape[i]].bounding_radius * p.scale[i]);
  diameter += options.binder_gap;
  for (std::size_t m = kSample; m <= n / 2; m = m < n / 2 ? std::min(n / 2, m + m / 2) : n) {
    std::vector<std::size_t> chosen(m);
    double volume = 0;
    for (std::size_t k = 0; k < m; ++k) chosen[k] = order[(2 * k + 1) * n / (2 * m)];
    for (const std::size_t i : chosen) volume += volume_of(p, shapes, i);
    const double edge = std::cbrt(volume / population.fraction);
    if (edge < 1.05 * diameter) continue;
    Packing sample;
    sample.box = Vec3::Constant(edge);
    std::vector<double> radius;
    for (const std::size_t i : chosen) {
      sample.shape.push_back(p.shape[i]), sample.scale.push_back(p.scale[i]),
          sample.size.push_back(p.size[i]);
      radius.push_back(std::cbrt(0.75 / std::numbers::pi * volume_of(p, shapes, i)));
    }
    sample.position.resize(m, Vec3::Zero());
    sample.orientation.resize(m, Quat::Identity());
    place_at_random(sample, 0, radius, options.seed, work.quiet());
    Budget budget;
    budget.limit = budget.expected = options.steps;
    const AnnealResult result = pack(contact_shapes, sample, options, budget, work);
    return {result.free ? population.fraction * std::pow(sample.shrink, 3) : 0, sample.shrink < 1,
            result.steps};
  }
  return {};
}

}  // namespace terrazzo::packing
