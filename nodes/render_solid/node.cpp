#include <algorithm>

#include "graph/node_type.h"
#include "nodes/common/color_config.h"
#include "nodes/data/volume.h"
#include "nodes/render_solid/color_field.h"
#include "nodes/render_solid/forms.h"
#include "nodes/render_solid/paint.h"
#include "nodes/render_solid/particle_index.h"
#include "nodes/render_solid/render.h"
#include "nodes/render_solid/residual_field.h"
#include "nodes/render_solid/tone.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

constexpr float degree = 0.0174532925f;

std::string resolved_mode(const Context& c) {
  const std::string mode = c.text("mode");
  if (mode != "auto") return mode;
  if (c.has("object")) return "object";
  return c.has("volume") || !c.has("particles") ? "block" : "particles";
}

void need(const Context& c, const std::string& what, const std::string& input) {
  if (!c.has(input))
    throw Error("no-" + input, what + " needs the input '" + input + "', which is not connected",
                input == "volume" ? "connect a volume with colours, such as Voxelize's" : "connect it");
}

Lie lie_of(const Context& c) {
  const auto three = [&](const char* name) {
    const auto v = c.numbers(name);
    if (v.size() != 3)
      throw Error(std::string("bad-") + name, std::to_string(v.size()) + " numbers are given",
                  "write x, y and z")
          .parameter(name);
    return Vec3(v[0], v[1], v[2]);
  };
  return Lie::of(three("turn"), three("shift"));
}

// What colours are looked up in, for as long as the picture takes.
struct Material {
  std::unique_ptr<ResidualField> residual;
  std::unique_ptr<ColorField> field;
  std::unique_ptr<Paint> paint;
};

// The fine detail on particles and binder, where there is one.
void take_residual(Context& c, Material& m) {
  const auto* volume = c.optional<Volume>("residual");
  if (!volume) return;
  m.residual =
      std::make_unique<ResidualField>(*volume, c.input<Particles>("particles").box, c.work().part(0, 0.05));
  const double scale = std::exp(m.residual->scale().array().log().abs().maxCoeff());
  c.metric("residual_scale", scale);
  if (scale > 1.25)
    c.warn("the residual is scaled by a factor of " + std::to_string(scale).substr(0, 4) +
           " to tile the box: a tile of another size keeps its scale");
}

// The colour inside, from voxels or from the particles themselves.
void take_paint(Context& c, const std::string& mode, Material& m) {
  const double repeat = mode == "fracture" ? 1 : c.number("repeat");
  std::string color = c.text("color");
  if (mode == "fracture")
    color = "particles";
  else if (color == "auto")
    color = c.has("volume") || !c.has("particles") ? "volume" : "particles";
  if (color == "particles") {
    need(c, "colour from particles", "particles"), need(c, "colour from particles", "shapes");
    const auto& particles = c.input<Particles>("particles");
    check_shown(particles, c.input<Shapes>("shapes"));
    take_residual(c, m);
    m.paint = particle_paint(particles, c.input<Shapes>("shapes"), repeat,
                             mode == "fracture" ? Lie{} : lie_of(c), m.residual.get());
    return;
  }
  need(c, "mode '" + mode + "'", "volume");
  if (c.has("residual"))
    c.warn("the residual is not used: the picture takes the volume's colours; color: particles takes both");
  m.field = std::make_unique<ColorField>(ColorField::of(c.input<Volume>("volume"), c.work().part(0, 0.05)));
  if (m.field->clamped() > 0.01f)
    c.warn("colours outside 0 to 1 in " + std::to_string(static_cast<int>(100 * m.field->clamped() + 0.5f)) +
           " % of the voxels were clamped, since no surface reflects more light than it gets");
  m.paint = field_paint(*m.field, repeat, lie_of(c), mode == "block" || mode == "cube");
}

// The holes that a packing with voids leaves in what is carved.
Voids voids_of(Context& c) {
  const auto* particles = c.optional<Particles>("particles");
  const auto* volume = c.optional<Volume>("volume");
  if (!particles && volume && volume->find<openvdb::FloatGrid>("void"))
    c.warn("the volume has voids, which are filled: connect the particles and their shapes to see the holes");
  if (!particles || particles->void_count() == 0) return {};
  need(c, "a packing with voids", "shapes");
  return {particles, &c.input<Shapes>("shapes"), c.number("repeat"), lie_of(c)};
}

std::unique_ptr<Solid> solid_of(Context& c, const std::string& mode, Material& m, std::uint64_t seed) {
  const Paint* paint = m.paint.get();
  const Voids voids = mode == "fracture" || mode == "particles" ? Voids{} : voids_of(c);
  if (mode == "block") return block_solid(*paint, c.number("cut"), kBevel, voids);
  if (mode == "cube") return block_solid(*paint, 0, kBevel, voids);
  if (mode == "vase") return object_solid(*paint, vase_form(), voids);
  if (mode == "knot") return object_solid(*paint, knot_form(), voids);
  if (mode == "object") {
    need(c, "mode 'object'", "object");
    const Shapes& shapes = c.input<Shapes>("object");
    if (shapes.shapes.empty()) throw Error("no-shapes", "the object has no mesh");
    if (shapes.shapes.size() > 1)
      c.warn("of the object's " + std::to_string(shapes.shapes.size()) + " meshes the first, '" +
             shapes.shapes[0].name + "', is shown");
    return object_solid(*paint, shapes.shapes[0], voids);
  }
  need(c, "mode '" + mode + "'", "particles"), need(c, "mode '" + mode + "'", "shapes");
  const auto& particles = c.input<Particles>("particles");
  const auto& shapes = c.input<Shapes>("shapes");
  if (mode == "fracture")
    return fracture_solid(*paint, particles, shapes, c.number("level"), c.number("roughness"), seed,
                          m.residual.get());
  check_shown(particles, shapes);
  take_residual(c, m);
  return particle_solid(particles, shapes, m.residual.get());
}

void compute(Context& c) {
  const std::string mode = resolved_mode(c);
  if (c.text("tone") == "view" && c.text("color_config") != color_config_id())
    throw Error(
        "color-config",
        "the colour configuration is '" + color_config_id() + "', not '" + c.text("color_config") + "'",
        "set the variable OCIO to the configuration that the graph was written for, or leave "
        "color_config out")
        .parameter("color_config");
  const Tone tone(c.text("tone"), c.text("view"));
  const float azimuth = degree * static_cast<float>(c.number("azimuth"));
  const float elevation = degree * static_cast<float>(c.number("elevation"));
  RenderSettings settings;
  settings.width = static_cast<int>(c.integer("width")),
  settings.height = static_cast<int>(c.integer("height"));
  settings.samples = static_cast<int>(c.integer("samples"));
  settings.gloss = static_cast<float>(c.number("gloss"));
  settings.seed = static_cast<std::uint64_t>(c.integer("seed"));

  Material material;
  if (mode != "particles") take_paint(c, mode, material);
  const std::unique_ptr<Solid> solid = solid_of(c, mode, material, settings.seed);

  const int frames = static_cast<int>(c.integer("frames"));
  Image turn(settings.width, settings.height, frames, 1);
  for (int i = 0; i < frames; ++i) {
    const float at = azimuth + 6.28318531f * static_cast<float>(i) / static_cast<float>(frames);
    Studio::Settings light;
    light.lamp_azimuth = at - 0.95f;  // from the viewer's left
    const Camera camera = Camera::framing(solid->bounds(), at, elevation, settings.width, settings.height);
    Image image = render(*solid, Studio(light), camera, settings,
                         c.work().part(0.05 + 0.95 * i / frames, 0.05 + 0.95 * (i + 1) / frames));
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
          "A picture of the solid: a block with a corner cut out, a body carved from it, or its particles "
          "alone, "
          "under one large lamp and a pale dome")
      .source_("Path tracing with a control variate: what an unoccluded surface gets is added in closed form")
      .optional_input("volume", {"Volume"}, "The solid: a colour grid `Cd`, repeated periodically")
      .optional_input("particles", {"Particles"},
                      "A packing: shown without its binder, broken, or carved at full resolution; its voids "
                      "are holes in what is carved, also where the colours are the volume's")
      .optional_input("shapes", {"Shapes"}, "The particles' forms")
      .optional_input("residual", {"Volume"},
                      "Grid residual of ResidualSynth: the photograph's fine detail on particles and binder, "
                      "where colours are theirs")
      .optional_input("object", {"Shapes"}, "A body to carve from the solid")
      .output("image", "Image", "Scene-linear and ready for display: 1 is white; a section a frame")
      .parameter(
          Parameter::integer("width", 720).unit_("pixels").range(1, 16384).doc_("Width of the picture"))
      .parameter(
          Parameter::integer("height", 720).unit_("pixels").range(1, 16384).doc_("Height of the picture"))
      .parameter(
          Parameter::integer("samples", 32)
              .range(1, 65536)
              .doc_("Light paths per pixel: four times as many halve the noise; powers of two spread best"))
      .parameter(
          Parameter::choice("mode", "auto",
                            {"auto", "block", "cube", "object", "vase", "knot", "particles", "fracture"})
              .doc_("block: a corner is cut out, which shows inner faces; cube: a whole block; object, vase, "
                    "knot: "
                    "carved from the solid; particles: without binder; fracture: one period broken across, "
                    "along the "
                    "particles' surfaces; auto: object where one is connected, else block, else particles"))
      .parameter(
          Parameter::choice("color", "auto", {"auto", "volume", "particles"})
              .doc_("Of what is carved: the volume's voxels, or the particles and their binder at full "
                    "resolution; auto: the volume where one is connected. A fracture takes the particles"))
      .parameter(Parameter::integer("frames", 1).range(1, 10000).doc_("Of one full turn; a section each"))
      .parameter(Parameter::numbers("turn", {0, 0, 0})
                     .count(3, 3)
                     .range(-360, 360)
                     .unit_("degrees")
                     .doc_("How the solid lies in what is carved from it, about x, then y, then z: on faces "
                           "oblique to "
                           "its period no repetition shows"))
      .parameter(Parameter::numbers("shift", {0, 0, 0})
                     .count(3, 3)
                     .range(-1000, 1000)
                     .doc_("How far it is shifted, in periods of x, y and z"))
      .parameter(Parameter::number("level", 0.6)
                     .range(0, 1)
                     .doc_("Of a fracture: the broken face's height, as a share"))
      .parameter(
          Parameter::number("roughness", 0.05)
              .range(0, 0.5)
              .doc_("Of a fracture: how far the binder's face goes up and down, as a share of the height"))
      .parameter(
          Parameter::choice("tone", "neutral", {"neutral", "aces", "view", "none"})
              .doc_("How strong light becomes a picture, through OpenColorIO: neutral keeps every colour up "
                    "to 0.85 and bends what is above; aces: the Academy's rendering for displays; view: one "
                    "of $OCIO's configuration; none: as it is"))
      .parameter(Parameter::text("view", "")
                     .doc_("With tone: view, a view of the configuration's default display, or "
                           "display/view; empty: the default view"))
      .parameter(Parameter::text("color_config", color_config_id())
                     .doc_("Identity of the colour configuration in force, so that a changed $OCIO is a "
                           "changed input. Write it only to insist on one"))
      .parameter(Parameter::number("repeat", 1)
                     .range(0.05, 64)
                     .doc_("Periods of the volume along the longest edge of the block or object"))
      .parameter(
          Parameter::number("cut", 0.5).range(0.05, 0.95).doc_("Share of each edge that the cut takes"))
      .parameter(
          Parameter::number("azimuth", -41)
              .unit_("degrees")
              .range(-360, 360)
              .doc_("Where the viewer stands, from +x towards +y; the cut corner is seen from −90 to 0"))
      .parameter(
          Parameter::number("elevation", 30).unit_("degrees").range(3, 85).doc_("How high the viewer stands"))
      .parameter(
          Parameter::number("gloss", 0.35).range(0, 1).doc_("0: matt; 1: mirrors as much as polished stone"))
      .parameter(Parameter::integer("seed", 1).range(0, 9007199254740991).doc_("Of the light paths"))
      .compute_(compute);
}

}  // namespace terrazzo
