#include "nodes/common/texture/color.h"

#include <cmath>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "graph/parameter.h"

namespace terrazzo {
namespace {

// Mirrored at zero, so that colors outside the gamut survive a round trip.
float decode(float v) {
  const float a = std::abs(v);
  return std::copysign(a <= 0.04045f ? a / 12.92f : std::pow((a + 0.055f) / 1.055f, 2.4f), v);
}
float encode(float v) {
  const float a = std::abs(v);
  return std::copysign(a <= 0.0031308f ? a * 12.92f : 1.055f * std::pow(a, 1 / 2.4f) - 0.055f, v);
}

}  // namespace

Vec3f srgb_to_linear(const Vec3f& encoded) { return encoded.unaryExpr(&decode); }
Vec3f linear_to_srgb(const Vec3f& linear) { return linear.unaryExpr(&encode); }

// Matrices of Ottosson's revision of 2021-01-25.
Vec3f linear_to_oklab(const Vec3f& c) {
  const float l = std::cbrt(0.4122214708f * c[0] + 0.5363325363f * c[1] + 0.0514459929f * c[2]);
  const float m = std::cbrt(0.2119034982f * c[0] + 0.6806995451f * c[1] + 0.1073969566f * c[2]);
  const float s = std::cbrt(0.0883024619f * c[0] + 0.2817188376f * c[1] + 0.6299787005f * c[2]);
  return {0.2104542553f * l + 0.7936177850f * m - 0.0040720468f * s,
          1.9779984951f * l - 2.4285922050f * m + 0.4505937099f * s,
          0.0259040371f * l + 0.7827717662f * m - 0.8086757660f * s};
}

Vec3f oklab_to_linear(const Vec3f& lab) {
  const float l = lab[0] + 0.3963377774f * lab[1] + 0.2158037573f * lab[2];
  const float m = lab[0] - 0.1055613458f * lab[1] - 0.0638541728f * lab[2];
  const float s = lab[0] - 0.0894841775f * lab[1] - 1.2914855480f * lab[2];
  const float l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
  return {4.0767416621f * l3 - 3.3077115913f * m3 + 0.2309699292f * s3,
          -1.2684380046f * l3 + 2.6097574011f * m3 - 0.3413193965f * s3,
          -0.0041960863f * l3 - 0.7034186147f * m3 + 1.7076147010f * s3};
}

Vec3f parse_color(const std::string& text) {
  std::string why;
  const auto v = read_parameter(Parameter::color("color", 0, 0, 0), {false, {text}}, why);
  if (!v) throw Error("bad-color", why).parameter("colors");
  const auto& rgb = std::get<std::vector<double>>(*v);
  return Vec3(rgb[0], rgb[1], rgb[2]).cast<float>();
}

}  // namespace terrazzo
