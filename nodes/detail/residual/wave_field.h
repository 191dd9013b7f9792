// Periodic Gaussian random fields that need no tile.
#pragma once

#include <span>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::residual {

// A sum of plane waves with the period of the box: nearly a Gaussian field of mean 0 and deviation 1, whose
// covariance at a distance r is Σ variance · exp(−r² / 4 sigma²). It never repeats within the box.
class WaveField {
 public:
  WaveField() = default;
  // `sigma`: mm, above 0; `variance`: of each, with the sum 1.
  WaveField(std::span<const float> sigma, std::span<const float> variance, const Vec3& box);

  float at(const Vec3f& mm) const;
  // Root mean square of the derivative along a line, per mm.
  float slope() const { return slope_; }

 private:
  std::vector<Vec3f> wave_;  // per mm
  std::vector<float> phase_;
  float slope_ = 0;
};

}  // namespace terrazzo::residual
