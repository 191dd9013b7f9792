#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/io/color_config.h"
#include "nodes/data/detail.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/render_solid/color_field.h"
#include "nodes/render_solid/forms.h"
#include "nodes/render_solid/paint.h"
#include "nodes/render_solid/particle_index.h"
#include "nodes/render_solid/render.h"
#include "nodes/render_solid/tone.h"
#include "nodes/residual/residual_field.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {
using namespace render_solid;

constexpr float degree = 0.0174532925f;

enum class Mode { Auto, Block, Cube, Object, Vase, Knot, Particles, Fracture };
enum class ColorSource { Auto, Volume, Particles };

const std::vector<std::string> kModes = {"auto", "block", "cube",      "object",
                                         "vase", "knot",  "particles", "fracture"};

Mode resolved_mode(const Context& c) {
  const auto mode = c.choice<Mode>("mode");
  if (mode != Mode::Auto) return mode;
  if (c.has("object")) return Mode::Object;
  return c.has("volume") || !c.has("particles") ? Mode::Block : Mode::Particles;
}

void need(const Context& c, const std::string& what, const std::string& input) {
  if (!c.has(input))
    throw Error("no-" + input, what + " needs the input '" + input + "', which is not connected",
                input == "volume" ? "connect a volume with colors, for example from Voxelize" : "connect it");
}

void need(const Context& c, Mode mode, const std::string& input) {
  need(c, "mode '" + kModes[static_cast<std::size_t>(mode)] + "'", input);
}

Placement placement_of(const NodeParameters& c) {
  const auto three = [&](const char* name) {
    const auto v = c.numbers(name);
    if (v.size() != 3)
      throw Error(std::string("bad-") + name, std::to_string(v.size()) + " numbers are given instead of 3",
                  "write x, y and z")
          .parameter(name);
    return Vec3(v[0], v[1], v[2]);
  };
  return Placement::of(three("turn"), three("shift"));
}

// Color sources that must live as long as the rendering.
struct Material {
  std::unique_ptr<residual::ResidualField> residual;
  std::unique_ptr<ColorField> field;
  std::unique_ptr<Paint> paint;
};

// Loads the fine detail of particles and binder, if connected.
void take_residual(Context& c, Material& m) {
  const auto& particles = c.input<Particles>("particles");
  if (const auto* detail = c.optional<Detail>("detail"))
    m.residual = std::make_unique<residual::ResidualField>(*detail, particles, 0, residual::Keep::Values,
                                                           c.work().part(0, 0.05));
  const auto* volume = c.optional<Volume>("detail");
  if (!volume) return;
  m.residual = std::make_unique<residual::ResidualField>(*volume, particles.box, c.work().part(0, 0.05));
  const double scale = std::exp(m.residual->scale().array().log().abs().maxCoeff());
  c.metric("residual_scale", scale);
  if (scale > 1.25)
    c.warn(
        fmt::format("the residual is scaled by a factor of {:.3g} to tile the box; synthesize it in another "
                    "size to keep its scale",
                    scale));
}

// Sets up the color inside, from voxels or from the particles themselves.
void take_paint(Context& c, Mode mode, Material& m) {
  const double repeat = mode == Mode::Fracture ? 1 : c.number("repeat");
  auto color = c.choice<ColorSource>("color");
  if (mode == Mode::Fracture)
    color = ColorSource::Particles;
  else if (color == ColorSource::Auto)
    color = c.has("volume") || !c.has("particles") ? ColorSource::Volume : ColorSource::Particles;
  if (color == ColorSource::Particles) {
    need(c, "color from particles", "particles"), need(c, "color from particles", "shapes");
    const auto& particles = c.input<Particles>("particles");
    check_shown(particles, c.input<Shapes>("shapes"));
    take_residual(c, m);
    m.paint = particle_paint(particles, c.input<Shapes>("shapes"), repeat,
                             mode == Mode::Fracture ? Placement{} : placement_of(c), m.residual.get());
    return;
  }
  need(c, mode, "volume");
  if (c.has("detail"))
    c.warn("the residual is not used, because colors come from the volume; set color: particles to use it");
  m.field = std::make_unique<ColorField>(ColorField::of(c.input<Volume>("volume"), c.work().part(0, 0.05)));
  if (m.field->clamped() > 0.01f)
    c.warn("colors outside 0 to 1 in " + std::to_string(static_cast<int>(100 * m.field->clamped() + 0.5f)) +
           " % of the voxels were clamped, since no surface reflects more light than it receives");
  m.paint = field_paint(*m.field, repeat, placement_of(c), mode == Mode::Block || mode == Mode::Cube);
}

// The voids of a packing, which become holes in the carved body.
Voids voids_of(Context& c) {
  const auto* particles = c.optional<Particles>("particles");
  const auto* volume = c.optional<Volume>("volume");
  if (!particles && volume && has_voids(*volume))
    c.warn(
        "the volume has voids, which are shown filled; connect the particles and their shapes to see the "
        "holes");
  if (!particles || particles->void_count() == 0) return {};
  need(c, "a packing with voids", "shapes");
  return {particles, &c.input<Shapes>("shapes"), c.number("repeat"), placement_of(c)};
}

std::unique_ptr<Solid> solid_of(Context& c, Mode mode, Material& m, std::uint64_t seed) {
  const Paint* paint = m.paint.get();
  const Voids voids = mode == Mode::Fracture || mode == Mode::Particles ? Voids{} : voids_of(c);
  if (mode == Mode::Block) return block_solid(*paint, c.number("cut"), kBevel, voids);
  if (mode == Mode::Cube) return block_solid(*paint, 0, kBevel, voids);
  if (mode == Mode::Vase) return object_solid(*paint, vase_form(), voids);
  if (mode == Mode::Knot) return object_solid(*paint, knot_form(), voids);
  if (mode == Mode::Object) {
    need(c, mode, "object");
    const Shapes& shapes = c.input<Shapes>("object");
    if (shapes.shapes.empty()) throw Error("no-shapes", "the object has no mesh");
    if (shapes.shapes.size() > 1)
      c.warn("the object has " + std::to_string(shapes.shapes.size()) + " meshes; only the first, '" +
             shapes.shapes[0].name + "', is shown");
    return object_solid(*paint, shapes.shapes[0], voids);
  }
  need(c, mode, "particles"), need(c, mode, "shapes");
  const auto& particles = c.input<Particles>("particles");
  const auto& shapes = c.input<Shapes>("shapes");
  if (mode == Mode::Fracture)
    return fracture_solid(*paint, particles, shapes, c.number("level"), c.number("roughness"), seed,
                          m.residual.get());
  check_shown(particles, shapes);
  take_residual(c, m);
  return particle_solid(particles, shapes, m.residual.get());
}

// Larger pictures have no previews.
constexpr std::size_t kMostShown = std::size_t{1} << 23;  // pixels

// Settings for a picture that is there at once.
RenderSettings coarse(RenderSettings settings) {
  constexpr double kPixels = 40000;
  const double reduced = std::sqrt(kPixels / (double(settings.width) * settings.height));
  if (reduced < 1) {
    settings.width = std::max(1, static_cast<int>(reduced * settings.width));
    settings.height = std::max(1, static_cast<int>(reduced * settings.height));
  }
  settings.samples = std::min(settings.samples, 4);
  return settings;
}

void check(const NodeParameters& p) { placement_of(p); }

void compute(Context& c) {
  const Mode mode = resolved_mode(c);
  const auto tone_kind = c.choice<ToneKind>("tone");
  if (tone_kind == ToneKind::View && c.text("color_config") != color_config_id())
    throw Error(
        "color-config",
        "the color configuration is '" + color_config_id() + "', not '" + c.text("color_config") + "'",
        "set the variable OCIO to the configuration that the graph was written for, or remove color_config")
        .parameter("color_config");
  const Tone tone(tone_kind, c.text("view"));
  const float azimuth = degree * static_cast<float>(c.number("azimuth"));
  const float elevation = degree * static_cast<float>(c.number("elevation"));
  RenderSettings settings;
  settings.width = static_cast<int>(c.integer("width")),
  settings.height = static_cast<int>(c.integer("height"));
  settings.samples = static_cast<int>(c.integer("samples"));
  settings.gloss = static_cast<float>(c.number("gloss"));
  settings.seed = c.seed();

  Material material;
  if (mode != Mode::Particles) take_paint(c, mode, material);
  const std::unique_ptr<Solid> solid = solid_of(c, mode, material, settings.seed);

  const int frames = static_cast<int>(c.integer("frames"));
  Image turn(settings.width, settings.height, frames, 1);
  const auto show = [&](Image image) {
    tone.apply(image);
    c.preview("image", std::move(image));
  };
  for (int i = 0; i < frames; ++i) {
    const float at = azimuth + 6.28318531f * static_cast<float>(i) / static_cast<float>(frames);
    Studio::Settings light;
    light.lamp_azimuth = at - 0.95f;  // to the camera's left
    const Camera camera = Camera::framing(solid->bounds(), at, elevation, settings.width, settings.height);
    // Of a turn, only the first frame is shown before the result.
    const bool shown = i == 0 && c.watched() && turn.index(0, 0, 1) <= kMostShown;
    if (shown) show(render(*solid, Studio(light), camera, coarse(settings), c.work().quiet()));
    Image image = render(*solid, Studio(light), camera, settings,
                         c.work().part(0.05 + 0.95 * i / frames, 0.05 + 0.95 * (i + 1) / frames),
                         shown ? show : std::function<void(Image)>());
    tone.apply(image);
    std::copy(image.pixels.begin(), image.pixels.end(),
              turn.pixels.begin() + static_cast<std::ptrdiff_t>(turn.index(0, 0, i)));
  }
  c.output("image", std::move(turn));
}

}  // namespace

NodeType render_solid_node() {
  return NodeType("RenderSolid", 4)
      .doc_(
          "Renders a picture of the solid under one large lamp and a pale dome: a block with a corner cut "
          "out, a body carved from it, or its particles without binder")
      .source_("Path tracing with a control variate: light on unoccluded surfaces is added in closed form")
      .optional_input("volume", {"Volume"}, "Solid: a color grid `Cd`, repeated periodically")
      .optional_input("particles", {"Particles"},
                      "Packing to show without its binder, as a fracture, or carved at full resolution. Its "
                      "voids are holes in carved bodies, even if colors come from the volume.")
      .optional_input("shapes", {"Shapes"}, "Shapes of the particles")
      .optional_input("detail", {"Detail", "Volume"},
                      "Fine detail of particles and binder from DetailSolid, or a volume with the grid "
                      "residual from ResidualSynth. Used only with colors from particles.")
      .input_was("residual")
      .optional_input("object", {"Shapes"}, "Body to carve from the solid")
      .output("image", "Image",
              "Picture with one section per frame, in linear values ready for display: 1 is white")
      .parameter(
          Parameter::integer("width", 720).unit_("pixels").range(1, 16384).doc_("Width of the picture"))
      .parameter(
          Parameter::integer("height", 720).unit_("pixels").range(1, 16384).doc_("Height of the picture"))
      .parameter(Parameter::integer("samples", 32)
                     .range(1, 65536)
                     .doc_("Light paths per pixel. Four times as many halve the noise; powers of two are "
                           "distributed best."))
      .parameter(
          Parameter::choice("mode", "auto", kModes)
              .doc_("block: a block with a corner cut out to show inner faces. cube: a whole block. object, "
                    "vase, knot: a body carved from the solid. particles: particles without binder. "
                    "fracture: one period broken across, along the particles' surfaces. auto: object if one "
                    "is connected, else block, else particles."))
      .parameter(Parameter::choice("color", "auto", {"auto", "volume", "particles"})
                     .doc_("Source of the colors of carved bodies. volume: its voxels. particles: particles "
                           "and binder at full resolution. auto: volume if one is connected, else particles. "
                           "A fracture always uses particles."))
      .parameter(Parameter::integer("frames", 1)
                     .range(1, 10000)
                     .doc_("Number of frames in one full turn, one section each"))
      .parameter(Parameter::numbers("turn", {0, 0, 0})
                     .count(3, 3)
                     .range(-360, 360)
                     .unit_("degrees")
                     .doc_("Rotation of the solid in the body carved from it, around x, then y, then z. "
                           "Faces oblique to its period show no repetition."))
      .parameter(Parameter::numbers("shift", {0, 0, 0})
                     .count(3, 3)
                     .range(-1000, 1000)
                     .doc_("Shift of the solid in the body carved from it, in periods of x, y and z"))
      .parameter(Parameter::number("level", 0.6)
                     .range(0, 1)
                     .doc_("Height of the broken face of a fracture, as a fraction of the block's height"))
      .parameter(Parameter::number("roughness", 0.05)
                     .range(0, 0.5)
                     .doc_("Amplitude of the binder's face in a fracture, up and down, as a fraction of the "
                           "block's height"))
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
      .parameter(Parameter::number("repeat", 1)
                     .range(0.05, 64)
                     .doc_("Periods of the volume along the longest edge of the block or object"))
      .parameter(
          Parameter::number("cut", 0.5).range(0.05, 0.95).doc_("Fraction of each edge that is cut out"))
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
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
