#include <cmath>
#include <vector>

#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/shapes/shape_estimate/methods/body_family.h"
#include "nodes/shapes/shape_estimate/methods/swelling.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {
namespace {

constexpr int kLobedLevel = 4;  // subdivision level of the sphere: 2,562 directions
constexpr double kNotch = 14;   // exponent of the mean of lobes: the larger, the sharper the notches

struct Lobe {
  Vec3 center;
  Mat3 inverse;  // maps the lobe to a unit ball
};

// Where a ray from the middle leaves the lobe; 0 if it misses it.
double exit_of(const Lobe& lobe, const Vec3& direction) {
  const Vec3 step = lobe.inverse * direction, center = lobe.inverse * lobe.center;
  const double along = center.dot(step),
               square = along * along - step.squaredNorm() * (center.squaredNorm() - 1);
  return along > 0 && square > 0 ? (along + std::sqrt(square)) / step.squaredNorm() : 0;
}

}  // namespace

Mesh lobed_body(std::uint64_t seed, int guess) {
  // A low-discrepancy sequence (Roberts 2018).
  const auto u = [&](int k) {
    constexpr double kLobedStep[] = {0.8567, 0.7339, 0.6287, 0.5386, 0.4614};
    return std::fmod(0.5 + kLobedStep[k] * (guess + 1), 1.0);
  };
  Random random(seed, 213, static_cast<std::uint64_t>(guess));
  const double away = 1 + 0.8 * u(1), spread = 0.1 + 0.25 * u(2), core = 0.8 + 0.6 * u(3);
  const Vec3 stretch(std::exp(0.4 * u(4)), 1, std::exp(-0.2 * u(4)));
  std::vector<Lobe> lobes;
  for (const Vec3& direction : spread_directions(random.bits(), 5 + static_cast<int>(10 * u(0)))) {
    const Vec3 radii = (spread * Vec3(random.normal(), random.normal(), random.normal())).array().exp();
    const Mat3 frame = frame_about(random_direction(random));
    lobes.push_back({away * direction, radii.cwiseInverse().asDiagonal() * frame.transpose()});
  }
  Mesh mesh = geodesic_sphere(kLobedLevel);
  for (Vec3& v : mesh.vertices) {
    double sum = std::pow(core, kNotch);
    for (const Lobe& lobe : lobes) sum += std::pow(exit_of(lobe, v), kNotch);
    v = (std::pow(sum, 1 / kNotch) * v).cwiseProduct(stretch);
  }
  return mesh;
}

}  // namespace terrazzo::shape_estimate
