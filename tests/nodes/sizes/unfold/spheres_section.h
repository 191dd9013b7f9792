// Profiles of random spheres, and their number in a result.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "runtime/random.h"

namespace terrazzo::test {

// The profiles of a window of `area` mm² through spheres with diameters uniform in [lo, hi] and number
// density `density` per mm³.
inline Profiles section(double lo, double hi, double density, double area, std::uint64_t seed) {
  Random random(seed);
  Profiles p;
  p.observed_area = area;
  double covered = 0;
  const int n = static_cast<int>(std::lround(density * area * (lo + hi) / 2));
  for (int i = 0; i < n; ++i) {
    // The probability that a plane meets a sphere is proportional to its diameter.
    double d;
    do d = random.uniform(lo, hi);
    while (random.uniform() * hi > d);
    const double h = random.uniform(0, d / 2);
    Profile q;
    q.area = std::numbers::pi * (d * d / 4 - h * h);
    covered += q.area;
    p.profiles.push_back(q);
  }
  p.area_fraction = covered / area;
  return p;
}

// Particles with sizes from lo to hi, per mm³.
inline double number(const SizeDistribution& d, double lo, double hi) {
  double sum = 0;
  for (const auto& e : d.shapes)
    for (std::size_t i = 0; i < d.classes(); ++i) {
      const double a = d.class_edges[i], b = d.class_edges[i + 1];
      sum += e.N_V[i] * std::max(0.0, std::min(b, hi) - std::max(a, lo)) / (b - a);
    }
  return sum;
}

}  // namespace terrazzo::test
