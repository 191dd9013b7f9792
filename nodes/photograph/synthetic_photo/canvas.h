// The scene as the camera will see it, at twice the photograph's resolution.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"

namespace terrazzo::synthetic_photo {

struct Canvas {
  int width = 0, height = 0;
  std::vector<float> z;             // height above the ground, in canvas pixels
  std::vector<std::int32_t> id;     // particle, from 1; 0: soil or binder
  std::vector<Vec3f> color;         // albedo, scene-linear
  std::vector<float> gloss;         // 0: matte, 1: wet
  std::vector<std::uint8_t> other;  // 1: not material
  int particles = 0;

  Canvas(int w, int h)
      : width(w),
        height(h),
        z(pixels_in(w, h), 0.0f),
        id(z.size(), 0),
        color(z.size(), Vec3f::Constant(0.2f)),
        gloss(z.size(), 0.0f),
        other(z.size(), 0) {}
  std::size_t at(int x, int y) const { return pixel_at(x, y, width); }
};

// Gaussian blur with clamped borders.
void blur(std::vector<float>& field, int width, int height, double sigma);

}  // namespace terrazzo::synthetic_photo
