#include "nodes/textures/relief/solid_look.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual/skins.h"

namespace terrazzo::textures {

double Roughness::of_class(std::int32_t cls) const {
  return particles[std::clamp(cls, 0, count_of(particles) - 1)];
}

Vec3f id_color(std::int32_t particle) {
  const std::uint32_t bits = (static_cast<std::uint32_t>(particle) + 1) * 0x9e3779b1u;
  return Vec3f(bits & 0xff, bits >> 8 & 0xff, bits >> 16 & 0xff) / 255;
}

Detail unlit(Detail detail) {
  if (!detail.tones.empty()) detail = residual::without_light(std::move(detail));  // of a surface
  for (Detail::Phase& phase : detail.phases) {
    phase.tilt.setZero();
    for (Detail::Rim& rim : phase.rims) {
      rim.right.clear();
      rim.up.clear();
    }
  }
  return detail;
}

void check_softness(const Detail& detail, double texel, const char* parameter, const char* hint) {
  constexpr double kMost = 50;  // texels
  const double mm = detail.softness * detail.pixel_size;
  if (mm / texel <= kMost) return;
  throw Error(
      "bad-value",
      fmt::format("the photograph blurs outlines by {:.3g} mm, which is {:.3g} texels of {:.3g} mm; at "
                  "most {:g} are possible",
                  mm, mm / texel, texel, kMost),
      hint)
      .parameter(parameter);
}

void require_one_solid(const Context& c) {
  const bool particles = c.has("particles"), shapes = c.has("shapes");
  if (c.has("volume") && (particles || shapes))
    throw Error("two-sources", "both particles and a volume are connected", "connect only one of them");
  if (c.has("volume") || (particles && shapes)) return;
  throw Error("missing-input",
              particles ? "particles are connected without their shapes"
              : shapes  ? "shapes are connected without particles"
                        : "neither particles nor a volume is connected",
              "connect particles and shapes, or a volume");
}

}  // namespace terrazzo::textures
