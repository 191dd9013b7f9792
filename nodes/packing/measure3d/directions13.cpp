#include "nodes/packing/measure3d/directions13.h"

#include <cmath>

#include "nodes/common/geometry/directions.h"

namespace terrazzo::measure3d {

std::array<double, kDirectionCount> direction_shares(const std::array<Vec3, kDirectionCount>& lines) {
  constexpr std::size_t kSamples = 60000;
  std::array<Vec3, kDirectionCount> unit = lines;
  for (Vec3& u : unit) u.normalize();
  std::array<double, kDirectionCount> share{};
  for (std::size_t i = 0; i < kSamples; ++i) {
    const Vec3 u = half_sphere_direction(i, kSamples);
    std::size_t best = 0;
    double most = -1;
    for (std::size_t d = 0; d < kDirectionCount; ++d)
      if (const double c = std::abs(u.dot(unit[d])); c > most) {
        most = c;
        best = d;
      }
    share[best] += 1.0 / kSamples;
  }
  return share;
}

}  // namespace terrazzo::measure3d
