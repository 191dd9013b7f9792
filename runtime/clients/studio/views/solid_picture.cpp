#include "runtime/clients/studio/views/solid_picture.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/particle_index.h"
#include "nodes/bodies/carving/solid.h"
#include "nodes/bodies/render_solid/render.h"
#include "nodes/bodies/render_solid/tone.h"
#include "nodes/common/geometry/camera.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo::studio {
namespace {

// Each shape once, on a square lattice whose cells are as wide as the largest.
Particles side_by_side(const Shapes& shapes) {
  Particles out;
  out.resize(shapes.shapes.size());
  double radius = 0;
  for (const Shape& s : shapes.shapes)
    for (const Vec3& v : s.mesh.vertices) radius = std::max(radius, v.norm());
  const std::size_t columns = std::ceil(std::sqrt(static_cast<double>(out.count())));
  const std::size_t rows = columns ? (out.count() + columns - 1) / columns : 0;
  const double cell = 2.1 * radius;
  out.box = cell * Vec3(static_cast<double>(columns), static_cast<double>(rows), 1);
  for (std::size_t i = 0; i < out.count(); ++i) {
    out.shape[i] = i;
    const double column = i % columns, row = rows - 1 - i / columns;
    out.position[i] = cell * Vec3(column + 0.5, row + 0.5, 0.5);
  }
  return out;
}

Image rendered(const carving::Solid& solid, double azimuth) {
  const render_solid::RenderOptions settings{.width = 640, .height = 480, .samples = 8};
  const float at = azimuth * std::numbers::pi / 180;
  render_solid::Studio::Settings light;
  light.lamp_azimuth = at - 0.95f;  // to the camera's left, as in RenderSolid
  Image out = render(solid, render_solid::Studio(light),
                     Camera::framing(solid.bounds(), at, 0.52f, settings.width, settings.height), settings);
  render_solid::Tone(render_solid::ToneKind::Neutral).apply(out);
  return out;
}

}  // namespace

Image solid_picture(const Value& solid, const Value& shapes, double azimuth) {
  if (solid.is<Volume>()) {
    const auto field = carving::ColorField::of(solid.as<Volume>());
    const auto paint = carving::field_paint(field);
    return rendered(*carving::block_solid(*paint), azimuth);
  }
  if (solid.is<Shapes>()) {
    const Particles each = side_by_side(solid.as<Shapes>());
    carving::check_shown(each, solid.as<Shapes>());
    return rendered(*carving::particle_solid(each, solid.as<Shapes>()), azimuth);
  }
  if (!solid.is<Particles>()) throw Error("bad-request", "only solids are rendered");
  if (!shapes || !shapes.is<Shapes>())
    throw Error("bad-request", "particles are rendered with their shapes, and none are given");
  carving::check_shown(solid.as<Particles>(), shapes.as<Shapes>());
  return rendered(*carving::particle_solid(solid.as<Particles>(), shapes.as<Shapes>()), azimuth);
}

}  // namespace terrazzo::studio
