#include "nodes/detail/residual/wave_field.h"

#include <cmath>
#include <numbers>

#include "runtime/random.h"

namespace terrazzo::residual {

WaveField::WaveField(std::span<const float> sigma, std::span<const float> variance, const Vec3& box) {
  constexpr int kWaves = 96, kTries = 16;
  constexpr std::uint64_t kStream = 0x77617665;
  double squares = 0;
  std::size_t k = 0;
  double below = variance.empty() ? 0 : double{variance[0]};
  for (int i = 0; i < kWaves; ++i) {
    while (k + 1 < sigma.size() && (i + 0.5) / kWaves > below) below += double{variance[++k]};
    Random random(1, kStream, static_cast<std::uint64_t>(i));
    Vec3 whole = Vec3::Zero();  // waves along each edge
    for (int t = 0; t < kTries && whole.isZero(); ++t)
      for (int a = 0; a < 3; ++a)
        whole[a] = std::round(random.normal() / (std::numbers::sqrt2 * double{sigma[k]}) * box[a] /
                              (2 * std::numbers::pi));
    if (whole.isZero()) whole.x() = 1;
    const Vec3 wave = 2 * std::numbers::pi * whole.cwiseQuotient(box);
    wave_.push_back(wave.cast<float>());
    phase_.push_back(static_cast<float>(random.uniform(0, 2 * std::numbers::pi)));
    squares += wave.squaredNorm();
  }
  slope_ = std::sqrt(squares / (3.0 * kWaves));
}

float WaveField::at(const Vec3f& mm) const {
  float sum = 0;
  for (std::size_t i = 0; i < wave_.size(); ++i) sum += std::cos(wave_[i].dot(mm) + phase_[i]);
  return sum * std::sqrt(2.0f / wave_.size());
}

}  // namespace terrazzo::residual
