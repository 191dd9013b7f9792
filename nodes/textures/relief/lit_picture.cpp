#include "nodes/textures/relief/lit_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terrazzo::textures {
namespace {

constexpr float kSky = 0.35f, kLamp = 0.9f;  // irradiance / π

// Of GGX with the visibility of Smith, times π and the cosine to the lamp.
float gloss(const Vec3f& n, const Vec3f& lamp, float roughness) {
  const Vec3f eye = Vec3f::UnitZ(), half = (lamp + eye).normalized();
  const float a = std::max(roughness * roughness, 1e-3f), square = a * a;
  const float l = n.dot(lamp), v = std::max(n.z(), 1e-3f), h = std::max(n.dot(half), 0.0f);
  if (l <= 0) return 0;
  const float t = h * h * (square - 1) + 1;
  const float visibility =
      0.5f / (l * std::sqrt(v * v * (1 - square) + square) + v * std::sqrt(l * l * (1 - square) + square));
  const float fresnel = 0.04f + 0.96f * std::pow(1 - std::max(half.dot(lamp), 0.0f), 5.0f);
  return square / (t * t) * visibility * fresnel * l;
}

}  // namespace

Image lit_picture(const Image& base_color, const Image& normal, const Image& roughness,
                  const Image& occlusion, const Work& work) {
  constexpr int kWidest = 1024;
  const Vec3f lamp = Vec3f(-1, 1, 1.2f).normalized();
  const int step = std::max(1, (2 * base_color.width + kWidest - 1) / kWidest);
  const int width = std::max(1, base_color.width / step), height = std::max(1, base_color.height / step);
  Image out(2 * width, 2 * height, 1, base_color.pixel_size * step);
  const auto shade = [&](std::size_t i) {
    const Vec3f n = (2 * normal.pixels[i] - Vec3f::Ones()).normalized();
    const float diffuse = kSky * occlusion.pixels[i].x() + kLamp * std::max(0.0f, n.dot(lamp));
    return Vec3f((diffuse * base_color.pixels[i]).array() + kLamp * gloss(n, lamp, roughness.pixels[i].x()));
  };
  work.quiet().parallel(height, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (int x = 0; x < width; ++x) {
        const int y = static_cast<int>(row);
        Vec3f sum = Vec3f::Zero();
        for (int dy = 0; dy < step; ++dy)
          for (int dx = 0; dx < step; ++dx) {
            const int from_x = std::min(x * step + dx, base_color.width - 1);
            sum += shade(base_color.index(from_x, std::min(y * step + dy, base_color.height - 1)));
          }
        const Vec3f color = sum / static_cast<float>(step * step);
        for (int k = 0; k < 4; ++k) out.at(x + k % 2 * width, y + k / 2 * height) = color;
      }
  });
  return out;
}

}  // namespace terrazzo::textures
