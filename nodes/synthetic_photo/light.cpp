#include "nodes/synthetic_photo/light.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::synthetic_photo {

Light random_light(Random& r, bool polished) {
  Light l;
  l.azimuth = r.uniform(0, 6.2832);
  l.elevation = r.uniform(0.35, 1.4);
  const double direct = r.uniform() < 0.35 ? r.uniform(0, 0.25) : r.uniform(0.2, 0.9);  // overcast or sunny
  l.sun = 1.3 * direct, l.sky = 1.15 * (1 - direct) + 0.08;
  l.occlusion = r.uniform(0.3, 1.6);
  l.softness = r.uniform(0.5, 6);
  if (polished) l.sun *= 0.3, l.sky = 1 - l.sun * 0.7, l.gloss = r.uniform() < 0.1 ? r.uniform(0, 0.3) : 0;
  return l;
}

std::vector<Vec3f> shade(const Canvas& c, const Light& l, const Work& work) {
  const std::size_t n = c.z.size();
  std::vector<float> open(n, 0);
  for (const double sigma : {2.5, 8.0, 26.0}) {
    std::vector<float> mean = c.z;
    blur(mean, c.width, c.height, sigma);
    for (std::size_t i = 0; i < n; ++i)
      open[i] += std::max(0.0f, mean[i] - c.z[i]) / static_cast<float>(1.2 * sigma);
  }
  const double ch = std::cos(l.elevation), sh = std::sin(l.elevation);
  const Vec3 sun(ch * std::cos(l.azimuth), ch * std::sin(l.azimuth), sh);
  const double slope = sh / ch, east = std::cos(l.azimuth), south = std::sin(l.azimuth);
  const Vec3 half = (sun + Vec3(0, 0, 1)).normalized();
  std::vector<Vec3f> out(n);
  for (int y = 0; y < c.height; ++y) {
    work.check();
    for (int x = 0; x < c.width; ++x) {
      const std::size_t i = c.at(x, y);
      const int x0 = std::max(0, x - 1), x1 = std::min(c.width - 1, x + 1), y0 = std::max(0, y - 1),
                y1 = std::min(c.height - 1, y + 1);
      const Vec3 normal = Vec3((c.z[c.at(x0, y)] - c.z[c.at(x1, y)]) / std::max(1, x1 - x0),
                               (c.z[c.at(x, y0)] - c.z[c.at(x, y1)]) / std::max(1, y1 - y0), 1)
                              .normalized();
      double lit = 1;
      if (l.sun > 0.05)
        for (double d = 1.5; d < 130 && lit > 0; d *= 1.22) {
          const int px = static_cast<int>(x + d * east + 0.5), py = static_cast<int>(y + d * south + 0.5);
          if (px < 0 || py < 0 || px >= c.width || py >= c.height) break;
          const double over = c.z[c.at(px, py)] - (c.z[i] + slope * d);
          lit = std::min(lit, 1 - over / (l.softness * 0.3 * std::sqrt(d) + 0.3));
        }
      lit = std::clamp(lit, 0.0, 1.0);
      const double facing = std::max(0.0, normal.dot(sun));
      const double sky = l.sky * std::exp(-l.occlusion * open[i]) * (0.65 + 0.35 * normal.z());
      Vec3f color = c.color[i] * static_cast<float>(l.sun * facing * lit + sky);
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
