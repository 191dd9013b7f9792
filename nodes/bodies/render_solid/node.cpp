#include <algorithm>
#include <cmath>
#include <functional>

#include "graph/node_type.h"
#include "nodes/bodies/carving/request.h"
#include "nodes/bodies/render_solid/render.h"
#include "nodes/bodies/render_solid/tone.h"
#include "nodes/common/io/pictures/color_config.h"
#include "nodes/data/profiles.h"
#include "runtime/context.h"

namespace terrazzo::render_solid {
namespace {
using namespace carving;

constexpr float kDegree = 0.0174532925f;

// Larger pictures have no previews.
constexpr std::size_t kMostShown = std::size_t{1} << 23;  // pixels

// Settings for a picture that is there at once.
RenderOptions coarse(RenderOptions settings) {
  constexpr double kPixels = 40000;
  const double reduced = std::sqrt(kPixels / (double(settings.width) * settings.height));
  if (reduced < 1) {
    settings.width = std::max<int>(1, reduced * settings.width);
    settings.height = std::max<int>(1, reduced * settings.height);
  }
  settings.samples = std::min(settings.samples, 4);
  return settings;
}

void compute(Context& c) {
  const carving::Mode mode = resolved_mode(c, c.optional<Profiles>("profiles"));
  const auto tone_kind = c.choice<ToneKind>("tone");
  if (tone_kind == ToneKind::View && c.text("color_config") != color_config_id())
    throw Error(
        "color-config",
        "the color configuration is '" + color_config_id() + "', not '" + c.text("color_config") + "'",
        "set the variable OCIO to the configuration that the graph was written for, or remove color_config")
        .parameter("color_config");
  const Tone tone(tone_kind, c.text("view"));
  const float azimuth = kDegree * static_cast<float>(c.number("azimuth"));
  const float elevation = kDegree * static_cast<float>(c.number("elevation"));
  RenderOptions settings;
  settings.width = c.integer("width");
  settings.height = c.integer("height");
  settings.samples = c.integer("samples");
  settings.gloss = c.number("gloss");
  settings.seed = c.seed();

  const carving::Body body = body_of(c, mode, settings.seed, c.ints("hide"));

  const int frames = c.integer("frames");
  Image turn(settings.width, settings.height, frames, 1);
  const auto show = [&](Image image) {
    tone.apply(image);
    c.preview("image", std::move(image));
  };
  for (int i = 0; i < frames; ++i) {
    const float at = azimuth + 6.28318531f * static_cast<float>(i) / frames;
    Studio::Settings light;
    light.lamp_azimuth = at - 0.95f;  // to the camera's left
    const Camera camera =
        Camera::framing(body.solid->bounds(), at, elevation, settings.width, settings.height);
    // Of a turn, only the first frame is shown before the result.
    const bool shown = i == 0 && c.watched() && turn.index(0, 0, 1) <= kMostShown;
    if (shown) show(render(*body.solid, Studio(light), camera, coarse(settings), c.work().quiet()));
    Image image = render(*body.solid, Studio(light), camera, settings,
                         c.work().part(0.05 + 0.95 * i / frames, 0.05 + 0.95 * (i + 1) / frames),
                         shown ? show : std::function<void(Image)>());
    tone.apply(image);
    std::copy(image.pixels.begin(), image.pixels.end(), turn.pixels.begin() + turn.index(0, 0, i));
  }
  c.output("image", std::move(turn));
}

}  // namespace
}  // namespace terrazzo::render_solid

namespace terrazzo {

NodeType render_solid_node() {
  using namespace render_solid;
  NodeType type("RenderSolid", 12);
  type.doc_(
          "Renders a picture of the solid under one large lamp and a pale dome: a block with a corner cut "
          "out, a body carved from it, or its particles without binder")
      .source_("Path tracing with a control variate: light on unoccluded surfaces is added in closed form");
  declare_solid(type);
  type.input_was("residual");
  type.optional_input(
      "profiles", {"Profiles"},
      "Profiles of the photograph, for mode auto: loose stones are shown without binder, others "
      "as a block");
  type.output("image", "Image",
              "Picture with one section per frame, in linear values ready for display: 1 is white")
      .parameter(
          Parameter::integer("width", 720).unit_("pixels").range(1, 16384).doc_("Width of the picture"))
      .parameter(
          Parameter::integer("height", 720).unit_("pixels").range(1, 16384).doc_("Height of the picture"))
      .parameter(Parameter::integer("samples", 32)
                     .range(1, 65536)
                     .doc_("Light paths per pixel: four for each ray from the camera if divisible by four, "
                           "or two if even. Four times as "
                           "many halve the noise; powers of two are distributed best."))
      .parameter(
          Parameter::choice("mode", "auto", kModes)
              .doc_("block: a block with a corner cut out to show inner faces. cube: a whole block. object, "
                    "vase, knot: a body carved from the solid. particles: particles without binder. "
                    "fracture: one period broken across, along the particles' surfaces. auto: particles if "
                    "the photograph shows loose stones, object if one is connected, block if `volume` or "
                    "`profiles` is, else particles."));
  declare_body(type);
  return type
      .parameter(Parameter::ints("hide", {})
                     .count(0, 32)
                     .range(0, 255)
                     .doc_("Phases of the volume's grid `phase` that are left out, such as pores, so that "
                           "the others show their shape. Needs colors from the volume."))
      .parameter(Parameter::integer("frames", 1)
                     .range(1, 10000)
                     .doc_("Number of frames in one full turn, one section each"))
      .parameter(Parameter::choice("tone", "neutral", {"neutral", "aces", "view", "none"})
                     .doc_("Tone mapping, by OpenColorIO. neutral: keeps colors up to 0.85 and compresses "
                           "values above. aces: the Academy's rendering for displays. view: a view of the "
                           "configuration in $OCIO. none: no tone mapping."))
      .parameter(Parameter::text("view", "")
                     .doc_("View for tone: view. Either a view of the configuration's default display, or "
                           "display/view. Empty: the default view."))
      .parameter(Parameter::text("color_config", color_config_id())
                     .doc_("Identity of the color configuration in use, so that a changed $OCIO counts as a "
                           "changed input. Set it only to require a particular configuration."))
      .parameter(
          Parameter::number("azimuth", -41)
              .unit_("degrees")
              .range(-360, 360)
              .doc_("Azimuth of the camera, from +x towards +y. The cut corner is visible from −90 to 0."))
      .parameter(
          Parameter::number("elevation", 30).unit_("degrees").range(3, 85).doc_("Elevation of the camera"))
      .parameter(Parameter::number("gloss", 0.35)
                     .range(0, 1)
                     .doc_("Strength of reflections: 0 is matte, 1 is polished stone"))
      .parameter(Parameter::seed())
      .check_(check_body)
      .compute_(compute);
}

}  // namespace terrazzo
