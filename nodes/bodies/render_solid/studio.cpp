#include "nodes/bodies/render_solid/studio.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::render_solid {
namespace {

constexpr double kPi = 3.14159265358979323846;

template <std::size_t N>
float interpolate(const std::array<float, N>& table, float cosine) {
  const float p = std::clamp((cosine + 1) * 0.5f * (N - 1), 0.0f, float(N - 1) - 0.001f);
  const int i = p;
  return table[i] + (table[i + 1] - table[i]) * (p - float(i));
}

// (1/π) ∫ f(d·axis) max(0, n·d) dω where n·axis = cosine.
template <class F>
double cosine_integral(double cosine, const F& f, double from, int rings) {
  constexpr int kTurns = 96;
  static const std::array<double, kTurns> across = [] {
    std::array<double, kTurns> out;
    for (int t = 0; t < kTurns; ++t) out[t] = std::cos(2 * kPi * (t + 0.5) / kTurns);
    return out;
  }();
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  double sum = 0;
  for (int r = 0; r < rings; ++r) {
    const double z = from + (1 - from) * (r + 0.5) / rings, s = std::sqrt(1 - z * z);
    double ring = 0;
    for (const double a : across) ring += std::max(0.0, cosine * z + sine * s * a);
    sum += f(z) * ring;
  }
  return sum * (1 - from) / rings * (2 * kPi / kTurns) / kPi;
}

// Two unit vectors that form a right-handed frame with the unit n. Duff et al., JCGT 6(1), 2017.
void frame(const Vec3f& n, Vec3f& a, Vec3f& b) {
  const float sign = std::copysign(1.0f, n.z());
  const float p = -1.0f / (sign + n.z()), q = n.x() * n.y() * p;
  a = Vec3f(1.0f + sign * n.x() * n.x() * p, sign * q, -sign * n.x());
  b = Vec3f(q, sign + n.y() * n.y() * p, -n.y());
}

}  // namespace

Studio::Studio(const Settings& s) : settings_(s) {
  direction_ = Vec3f(std::cos(s.lamp_elevation) * std::cos(s.lamp_azimuth),
                     std::cos(s.lamp_elevation) * std::sin(s.lamp_azimuth), std::sin(s.lamp_elevation));
  frame(direction_, across_, along_);
  const double k = s.lamp_sharpness;
  tail_ = std::exp(-2 * k);
  const auto lobe = [k](double z) { return k / (2 * kPi * (1 - std::exp(-2 * k))) * std::exp(k * (z - 1)); };
  const double from = std::max(-1.0, 1 - 20 / k);
  for (int i = 0; i <= kSteps; ++i)
    by_angle_[i] = kPi * cosine_integral(-1 + 2.0 * i / kSteps, lobe, from, 256);
  const float facing = interpolate(by_angle_, direction_.z());
  lamp_ = s.lamp_share > 0 ? s.lamp_share / facing : 0;

  const auto relative = [&](double z) { return z < 0 ? 0.0 : s.horizon + (s.zenith - s.horizon) * z; };
  const double up = cosine_integral(1, relative, -1, 256);
  const float dome = (1 - s.lamp_share) / up;
  horizon_ = s.horizon * dome;
  zenith_ = s.zenith * dome;
  const auto all = [&](double z) { return z < 0 ? double(s.floor) : horizon_ + (zenith_ - horizon_) * z; };
  for (int i = 0; i <= kSteps; ++i) by_height_[i] = cosine_integral(-1 + 2.0 * i / kSteps, all, -1, 256);
}

Studio Studio::furnace() {
  Settings s;
  s.lamp_share = 0;
  s.horizon = s.zenith = s.floor = s.background = 1;
  s.has_floor = false;
  Studio studio(s);
  // Set the constants directly, without the tables' quadrature error.
  studio.horizon_ = studio.zenith_ = 1;
  studio.by_height_.fill(1);
  studio.by_angle_.fill(0);
  return studio;
}

float Studio::irradiance(const Vec3f& normal) const {
  return interpolate(by_height_, normal.z()) +
         (lamp_ > 0 ? lamp_ * interpolate(by_angle_, normal.dot(direction_)) : 0);
}

float Studio::mirrored(const Vec3f& direction) const {
  // Wider than the lamp itself, so that its reflection is soft.
  const float gleam = lamp_ > 0 ? 2.5f * lamp_ * std::exp(6 * (direction.dot(direction_) - 1)) : 0;
  return direction.z() < 0 ? settings_.floor : radiance(direction) + gleam;
}

Vec3f Studio::to_lamp(float u, float v) const {
  const float k = settings_.lamp_sharpness;
  const float z = std::max(-1.0f, 1 + std::log(1 - u + u * tail_) / k);
  const float s = std::sqrt(std::max(0.0f, 1 - z * z)), turn = 2 * static_cast<float>(kPi) * v;
  return direction_ * z + across_ * (s * std::cos(turn)) + along_ * (s * std::sin(turn));
}

Vec3f cosine_direction(const Vec3f& normal, float u, float v) {
  Vec3f a, b;
  frame(normal, a, b);
  const float r = std::sqrt(u), turn = 2 * static_cast<float>(kPi) * v;
  return a * (r * std::cos(turn)) + b * (r * std::sin(turn)) + normal * std::sqrt(std::max(0.0f, 1 - u));
}

}  // namespace terrazzo::render_solid
