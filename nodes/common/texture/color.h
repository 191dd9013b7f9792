// Color conversion of single values; images are converted through OpenColorIO (color_config.h).
#pragma once

#include <string>

#include "nodes/data/linear.h"

namespace terrazzo {

Vec3f srgb_to_linear(const Vec3f& encoded);  // IEC 61966-2-1, component-wise, 0 to 1
Vec3f linear_to_srgb(const Vec3f& linear);
// Oklab (Ottosson 2020) from and to scene-linear Rec. 709. Perceptually uniform, L in 0 to 1.
Vec3f linear_to_oklab(const Vec3f& linear);
Vec3f oklab_to_linear(const Vec3f& lab);
// Scene-linear color of "#rrggbb" (sRGB) or three scene-linear numbers, an element of the parameter `colors`.
// Throws Error "bad-color".
Vec3f parse_color(const std::string& text);

}  // namespace terrazzo
