#include "nodes/photograph/synthetic_photo/light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace terrazzo::synthetic_photo {
namespace {

constexpr int kDirections = 8;  // in which horizons are looked for
constexpr double kFarthest = 110;

struct Sky {
  float light = 0;   // on the surface, relative to an open plane under an even sky
  float hidden = 0;  // share of the sky that other surfaces hide
};

// Light of a sky whose radiance depends on the azimuth only. In each direction, the part of the sky above the
// horizon is integrated with the cosine to the normal in closed form.
class SkyLight {
 public:
  SkyLight(const Canvas& c, const Light& l) : c_(c), light_(l) {
    for (int k = 0; k < kDirections; ++k) {
      const double a = 6.283185 * (k + 0.5) / kDirections;
      x_[k] = std::cos(a);
      y_[k] = std::sin(a);
      radiance_[k] = 1 + l.sky_slope * std::cos(a - l.sky_azimuth);
    }
    for (double d = 1.5; d < kFarthest; d *= 1.45) distances_.push_back(d);
  }

  Sky operator()(int x, int y, const Vec3& normal) const {
    const float z = c_.z[c_.at(x, y)];
    Sky sky;
    for (int k = 0; k < kDirections; ++k) {
      double steepest = 0;  // tangent of the horizon
      for (const double d : distances_) {
        const int px = static_cast<int>(x + d * x_[k] + 0.5), py = static_cast<int>(y + d * y_[k] + 0.5);
        if (px < 0 || py < 0 || px >= c_.width || py >= c_.height) break;
        steepest = std::max(steepest, (c_.z[c_.at(px, py)] - z) / d);
      }
      steepest *= light_.relief;
      const double horizon = std::atan(steepest), sine = steepest / std::sqrt(1 + steepest * steepest);
      const double toward = normal.x() * x_[k] + normal.y() * y_[k];
      const double part =
          toward * (0.785398 - horizon / 2 - std::sin(2 * horizon) / 4) + normal.z() * (1 - sine * sine) / 2;
      sky.light += static_cast<float>(radiance_[k] * std::max(0.0, part) * 2 / kDirections);
      sky.hidden += static_cast<float>(sine * sine / kDirections);
    }
    return sky;
  }

 private:
  const Canvas& c_;
  const Light& light_;
  std::array<double, kDirections> x_{}, y_{}, radiance_{};
  std::vector<double> distances_;
};

// The share of the sun's disc that is seen, with soft edges.
double sunlit(const Canvas& c, const Light& l, int x, int y, double slope, double east, double south) {
  const float z = c.z[c.at(x, y)];
  double lit = 1;
  for (double d = 1.5; d < 130 && lit > 0; d *= 1.22) {
    const int px = static_cast<int>(x + d * east + 0.5), py = static_cast<int>(y + d * south + 0.5);
    if (px < 0 || py < 0 || px >= c.width || py >= c.height) break;
    const double over = c.z[c.at(px, py)] - (z + slope * d);
    lit = std::min(lit, 1 - over / (l.softness * 0.3 * std::sqrt(d) + 0.3));
  }
  return std::clamp(lit, 0.0, 1.0);
}

}  // namespace

Light random_light(Random& r, bool polished, bool face) {
  constexpr double kUp = -1.5708;
  Light l;
  const bool above = face && r.uniform() < 0.7;
  l.azimuth = above ? kUp + 0.6 * r.normal() : r.uniform(0, 6.2832);
  l.elevation = r.uniform(0.35, 1.4);
  const double direct = r.uniform() < 0.5 ? r.uniform(0, 0.25) : r.uniform(0.2, 0.9);  // overcast or sunny
  l.sun = 1.3 * direct;
  l.sky = 1.15 * (1 - direct) + 0.08;
  l.sky_azimuth = above ? kUp + 0.3 * r.normal() : r.uniform(0, 6.2832);
  l.sky_slope = r.uniform() < 0.3 ? 0 : r.uniform(0.1, 1);
  l.relief = r.uniform(0.5, 1.5);
  l.bounce = r.uniform(0.1, 0.6);
  l.softness = r.uniform(0.5, 6);
  if (polished) {
    l.sun *= 0.3;
    l.sky = 1 - l.sun * 0.7;
    l.gloss = r.uniform() < 0.1 ? r.uniform(0, 0.3) : 0;
  }
  return l;
}

std::vector<Vec3f> shade(const Canvas& c, const Light& l, const Work& work) {
  const SkyLight sky_light(c, l);
  const double ch = std::cos(l.elevation), sh = std::sin(l.elevation);
  const Vec3 sun(ch * std::cos(l.azimuth), ch * std::sin(l.azimuth), sh);
  const double slope = sh / ch, east = std::cos(l.azimuth), south = std::sin(l.azimuth);
  const Vec3 half = (sun + Vec3(0, 0, 1)).normalized();
  Vec3f mean = Vec3f::Zero();
  for (const Vec3f& v : c.color) mean += v / static_cast<float>(c.color.size());
  std::vector<Vec3f> out(c.z.size());
  for (int y = 0; y < c.height; ++y) {
    work.check();
    for (int x = 0; x < c.width; ++x) {
      const std::size_t i = c.at(x, y);
      const int x0 = std::max(0, x - 1), x1 = std::min(c.width - 1, x + 1), y0 = std::max(0, y - 1),
                y1 = std::min(c.height - 1, y + 1);
      const Vec3 normal = Vec3((c.z[c.at(x0, y)] - c.z[c.at(x1, y)]) / std::max(1, x1 - x0),
                               (c.z[c.at(x, y0)] - c.z[c.at(x, y1)]) / std::max(1, y1 - y0), 1)
                              .normalized();
      const double lit = l.sun > 0.05 ? sunlit(c, l, x, y, slope, east, south) : 1;
      const double facing = std::max(0.0, normal.dot(sun));
      const Sky sky = sky_light(x, y, normal);
      const Vec3f around = Vec3f::Constant(static_cast<float>(l.sun * facing * lit + l.sky * sky.light)) +
                           mean * static_cast<float>((l.sun + l.sky) * l.bounce) * sky.hidden;
      Vec3f color = c.color[i].cwiseProduct(around);
      if (const double gloss = std::max<double>(c.gloss[i], l.gloss); gloss > 0) {
        color *= static_cast<float>(1 - 0.4 * gloss);
        color.array() += static_cast<float>(gloss * lit * (0.1 + l.sun) * 0.7 *
                                            std::pow(std::max(0.0, normal.dot(half)), 60));
      }
      out[i] = color;
    }
  }
  return out;
}

}  // namespace terrazzo::synthetic_photo
