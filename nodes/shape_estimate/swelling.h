// Functions of the direction by which bodies swell and shrink.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::shape_estimate {

constexpr int harmonic_count(int degrees) { return (degrees + 1) * (degrees + 1) - 4; }

// Real spherical harmonics of a unit vector, degrees 2 to `degrees` ≤ 6, each of unit mean square over the
// sphere: harmonic_count(degrees) numbers, of degree n those from harmonic_count(n − 1) on.
void harmonics(const Vec3& unit, int degrees, double* out);

// Random functions of the direction, each of unit mean square, of ever shorter waves: 1 to 1.6, .55 to .9,
// .35 to .55 and .22 to .35 of the radius.
class Fields {
 public:
  static constexpr int kCount = 4;
  static constexpr double kAmplitude[kCount] = {0.05, 0.03, 0.015, 0.008};  // what one sees
  explicit Fields(std::uint64_t seed);
  double operator()(int k, const Vec3& unit) const;

 private:
  static constexpr int kWaves = 20;
  Vec3 wave_[kCount][kWaves];
  double phase_[kCount][kWaves];
};

// About as far apart as so many can be.
std::vector<Vec3> spread_directions(std::uint64_t seed, int count);

double bounded(double v, double most);  // v for small v, never beyond ±most

}  // namespace terrazzo::shape_estimate
