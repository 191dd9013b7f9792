#include "nodes/bodies/view/shader.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terrazzo::view {
namespace {

constexpr float kDegree = std::numbers::pi_v<float> / 180;
// Of the bright part of the sky: photographs of stones are taken in the shade or under clouds, or their rough
// surfaces blur the border of light.
constexpr float kSunRadius = 35 * kDegree;
constexpr int kRing = 4;                // places on each of two rings of the sun's disc
constexpr float kRings[] = {0.35F, 1};  // from its middle, in its radius
constexpr int kSuns = 2 * kRing;
constexpr int kSkyRays = 16;

// Two unit vectors across a unit vector (Duff et al. 2017).
struct Across {
  Vec3f first, second;
  explicit Across(const Vec3f& n) {
    const float sign = std::copysign(1.0f, n.z());
    const float a = -1 / (sign + n.z());
    const float b = n.x() * n.y() * a;
    first = Vec3f(1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
    second = Vec3f(b, sign + n.y() * n.y() * a, -n.y());
  }
};

// Van der Corput's sequence of 16 members.
float reversed_bits(int i) {
  const int bits = (i & 1) * 8 + (i & 2) * 2 + (i & 4) / 2 + (i & 8) / 8;
  return static_cast<float>(bits) / kSkyRays;
}

// Of an overcast sky, which is three times as bright above as at the horizon (Moon and Spencer 1942, the
// CIE's standard), relative to what a level place in the open gets on average, weighted by the cosine.
float brightness_of_sky(float height) { return (1 + 2 * height) * 3 / 7; }

float fraction(float v) { return v - std::floor(v); }

// The upper and the lower half of a random number, from 0 to 1.
float upper_half(std::uint64_t bits) { return static_cast<float>(bits >> 40) * 0x1p-24f; }
float lower_half(std::uint64_t bits) { return static_cast<float>(bits & 0xffffff) * 0x1p-24f; }

}  // namespace

Shader::Shader(const Bed& bed, const Light& light, double reach, double lift)
    : bed_(bed), reach_(static_cast<float>(reach)), lift_(static_cast<float>(lift)) {
  const double azimuth = light.azimuth * kDegree;
  const double elevation = light.elevation * kDegree;
  middle_ = Vec3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                 std::sin(elevation))
                .cast<float>();
  for (int k = 0; k < kSuns; ++k) level_ += std::max(0.0F, toward_sun(k, 0).z()) / kSuns;
}

// To one of the places on the sun, whose rings are turned by a share of the angle between two places.
Vec3f Shader::toward_sun(int place, float shift) const {
  const Across across(middle_);
  const float turn = (shift + place + 0.5F * (place / kRing)) * 2 * std::numbers::pi_v<float> / kRing;
  const Vec3f side = std::cos(turn) * across.first + std::sin(turn) * across.second;
  return (middle_ + std::tan(kRings[place / kRing] * kSunRadius) * side).normalized();
}

float Shader::sun(const BedPoint& point, std::uint64_t random) const {
  const float shift = upper_half(random);
  float sum = 0;
  for (int k = 0; k < kSuns; ++k) {
    const Vec3f direction = toward_sun(k, shift);
    const float cosine = point.normal.dot(direction);
    if (cosine <= 0 || direction.z() <= 0) continue;  // away from the sun, or the sun below the ground
    // A smooth mesh is lit a little beyond the facets that face the sun.
    if (point.face.dot(direction) > 0 && bed_.hides(start(point), direction)) continue;
    sum += cosine;
  }
  return sum / (kSuns * level_);
}

// In the deepest gaps, where few rays see the sky, twelve times as many tell more or less of it from none.
float Shader::sky(const BedPoint& point, std::uint64_t random) const {
  constexpr int kFew = 3, kSets = 12;
  constexpr float kUnseen = 0.5F;  // rays: none of so many does not mean that nothing is open
  const float shift = upper_half(random);
  const float turn = lower_half(random);
  float open = open_rays(point, shift, turn);
  int sets = 1;
  for (; open <= static_cast<float>(kFew * sets) && sets < kSets; ++sets) {
    const float between = static_cast<float>(sets) / (kSets * kSkyRays);
    open += open_rays(point, shift + between, turn + between);
  }
  return std::max(kUnseen, open) / static_cast<float>(sets * kSkyRays);
}

float Shader::open_rays(const BedPoint& point, float shift, float turn) const {
  const Across across(point.normal);
  float open = 0;
  for (int k = 0; k < kSkyRays; ++k) {
    const float u = fraction((k + 0.5f) / kSkyRays + shift);
    const float phi = 2 * std::numbers::pi_v<float> * fraction(reversed_bits(k) + turn);
    const float r = std::sqrt(u);
    const Vec3f direction = r * std::cos(phi) * across.first + r * std::sin(phi) * across.second +
                            std::sqrt(1 - u) * point.normal;
    if (direction.z() <= 0) continue;  // the ground
    if (point.face.dot(direction) > 0 && bed_.hides(start(point), direction, reach_)) continue;
    open += brightness_of_sky(direction.z());
  }
  return open;
}

}  // namespace terrazzo::view
