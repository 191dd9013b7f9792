// Functions of direction by which bodies swell and shrink.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::shape_estimate {

constexpr int harmonic_count(int degrees) { return (degrees + 1) * (degrees + 1) - 4; }

// Real spherical harmonics of a unit vector, degrees 2 to `degrees` ≤ 6, each with unit mean square over the
// sphere. Writes harmonic_count(degrees) numbers; those of degree n start at harmonic_count(n − 1).
void harmonics(const Vec3& unit, int degrees, double* out);

// Random functions of direction with unit mean square and decreasing wavelengths: 1 to 1.6, 0.55 to 0.9, 0.35
// to 0.55 and 0.22 to 0.35 of the radius.
class Fields {
 public:
  static constexpr int kCount = 4;
  static constexpr double kAmplitude[kCount] = {0.05, 0.03, 0.015, 0.008};  // just visible amplitudes
  explicit Fields(std::uint64_t seed);
  double operator()(int k, const Vec3& unit) const;

 private:
  static constexpr int kWaves = 20;
  Vec3 wave_[kCount][kWaves];
  double phase_[kCount][kWaves];
};

// `count` random directions, about as far apart as possible.
std::vector<Vec3> spread_directions(std::uint64_t seed, int count);

double bounded(double v, double most);  // about v for small v, never beyond ±most

}  // namespace terrazzo::shape_estimate
