#include "nodes/packing/cells/warp.h"

#include <cmath>
#include <numbers>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::tessellation {
namespace {

constexpr std::uint64_t kWaves = 0x7761766573;
constexpr int kOctaves = 3, kPerOctave = 12;

}  // namespace

Warp::Warp(const Vec3& box, double coarsest, double displacement, std::uint64_t seed) {
  constexpr double kTurn = 2 * std::numbers::pi;
  Random random(seed, kWaves);
  double squares = 0;
  for (int o = 0; o < kOctaves; ++o)
    for (int k = 0; k < kPerOctave; ++k) {
      const double length = std::min(coarsest, box.minCoeff()) * std::pow(0.5, o + random.uniform());
      const double z = random.uniform(-1, 1), angle = kTurn * random.uniform();
      const Vec3 direction(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
      Wave wave;
      for (int a = 0; a < 3; ++a)  // a whole number of waves along each edge
        wave.vector[a] = kTurn * std::round(direction[a] / length * box[a]) / box[a];
      const double turn = kTurn * random.uniform();
      wave.phase = kTurn * random.uniform();
      if (wave.vector.isZero()) continue;
      const Vec3 u = wave.vector.unitOrthogonal(), v = wave.vector.normalized().cross(u);
      wave.amplitude = length * (std::cos(turn) * u + std::sin(turn) * v);
      squares += 0.5 * wave.amplitude.squaredNorm();
      waves_.push_back(wave);
    }
  double gradient = 0;
  for (Wave& w : waves_) {
    w.amplitude *= displacement / std::sqrt(squares);
    gradient += 0.5 * w.amplitude.squaredNorm() * w.vector.squaredNorm();
  }
  // A step is invertible if its displacement's gradient is below 1 everywhere: eight root mean squares.
  steps_ = std::max(1, round_up(8 * std::sqrt(gradient)));
  for (Wave& w : waves_) w.amplitude /= steps_;
}

Vec3 Warp::operator()(Vec3 point) const {
  for (int s = 0; s < steps_; ++s) {
    Vec3 step = Vec3::Zero();
    for (const Wave& w : waves_) step += w.amplitude * std::cos(w.vector.dot(point) + w.phase);
    point += step;
  }
  return point;
}

}  // namespace terrazzo::tessellation
