#include "nodes/bodies/view/light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terrazzo::view {
namespace {

constexpr double kUsualAzimuth = 135;  // degrees: pictures are usually lit from the upper left
constexpr double kUsualSlope = 0.4;
constexpr double kSteepestSlope = 0.8;
constexpr double kHighSun = 60, kLowSun = 40;  // degrees, without a slope and with the steepest
constexpr double kOvercastShare = 0.15, kClearShare = 0.8;
constexpr double kRadians = std::numbers::pi / 180;

}  // namespace

Light light_of(const std::optional<Vec2>& slope, std::optional<double> azimuth,
               std::optional<double> elevation) {
  const double strength = slope ? slope->norm() : kUsualSlope;
  const bool directed = slope && strength > 0;
  Light light;
  light.azimuth = azimuth.value_or(directed ? std::atan2(slope->y(), slope->x()) / kRadians : kUsualAzimuth);
  const double steep = std::min(1.0, strength / kSteepestSlope);
  light.elevation = elevation.value_or(kHighSun + steep * (kLowSun - kHighSun));
  light.share = std::clamp(strength * std::tan(light.elevation * kRadians), kOvercastShare, kClearShare);
  light.slope = strength * Vec2(std::cos(light.azimuth * kRadians), std::sin(light.azimuth * kRadians));
  return light;
}

}  // namespace terrazzo::view
