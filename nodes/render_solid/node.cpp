#include "graph/node_type.h"
#include "nodes/data/volume.h"
#include "nodes/render_solid/color_field.h"
#include "nodes/render_solid/render.h"
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

void need(const Context& c, const std::string& mode, const std::string& input) {
  if (!c.has(input))
    throw Error("no-" + input, "mode '" + mode + "' needs the input '" + input + "', which is not connected",
                input == "volume" ? "connect a volume with colours, such as Voxelize's" : "connect it");
}

void compute(Context& c) {
  const std::string mode = resolved_mode(c);
  const float azimuth = degree * static_cast<float>(c.number("azimuth"));
  const float elevation = degree * static_cast<float>(c.number("elevation"));
  RenderSettings settings;
  settings.width = static_cast<int>(c.integer("width")),
  settings.height = static_cast<int>(c.integer("height"));
  settings.samples = static_cast<int>(c.integer("samples"));
  settings.gloss = static_cast<float>(c.number("gloss"));
  settings.seed = static_cast<std::uint64_t>(c.integer("seed"));

  std::unique_ptr<ColorField> field;
  if (mode != "particles") {
    need(c, mode, "volume");
    field = std::make_unique<ColorField>(ColorField::of(c.input<Volume>("volume"), c.work().part(0, 0.05)));
    if (field->clamped() > 0.01f)
      c.warn("colours outside 0 to 1 in " + std::to_string(static_cast<int>(100 * field->clamped() + 0.5f)) +
             " % of the voxels were clamped, since no surface reflects more light than it gets");
  }
  std::unique_ptr<Solid> solid;
  const double repeat = c.number("repeat");
  if (mode == "block") {
    solid = block_solid(*field, repeat, c.number("cut"));
  } else if (mode == "cube") {
    solid = block_solid(*field, repeat, 0);
  } else if (mode == "object") {
    need(c, mode, "object");
    const Shapes& shapes = c.input<Shapes>("object");
    if (shapes.shapes.empty()) throw Error("no-shapes", "the object has no mesh");
    if (shapes.shapes.size() > 1)
      c.warn("of the object's " + std::to_string(shapes.shapes.size()) + " meshes the first, '" +
             shapes.shapes[0].name + "', is shown");
    solid = object_solid(*field, shapes.shapes[0], repeat);
  } else {
    need(c, mode, "particles"), need(c, mode, "shapes");
    solid = particle_solid(c.input<Particles>("particles"), c.input<Shapes>("shapes"));
  }

  Studio::Settings light;
  light.lamp_azimuth = azimuth - 0.95f;  // from the viewer's left
  const Camera camera = Camera::framing(solid->bounds(), azimuth, elevation, settings.width, settings.height);
  c.output("image", render(*solid, Studio(light), camera, settings, c.work().part(0.05, 1)));
}

}  // namespace

NodeType render_solid_node() {
  return NodeType("RenderSolid", 1)
      .doc_(
          "A picture of the solid: a block with a corner cut out, a body carved from it, or its particles "
          "alone, "
          "under one large lamp and a pale dome")
      .source_("Path tracing with a control variate: what an unoccluded surface gets is added in closed form")
      .optional_input("volume", {"Volume"}, "The solid: a colour grid `Cd`, repeated periodically")
      .optional_input("particles", {"Particles"}, "A packing, shown without its binder")
      .optional_input("shapes", {"Shapes"}, "The particles' forms")
      .optional_input("object", {"Shapes"}, "A body to carve from the solid")
      .output("image", "Image", "Scene-linear and ready for display: 1 is white")
      .parameter(
          Parameter::integer("width", 720).unit_("pixels").range(1, 16384).doc_("Width of the picture"))
      .parameter(
          Parameter::integer("height", 720).unit_("pixels").range(1, 16384).doc_("Height of the picture"))
      .parameter(
          Parameter::integer("samples", 32)
              .range(1, 65536)
              .doc_("Light paths per pixel: four times as many halve the noise; powers of two spread best"))
      .parameter(
          Parameter::choice("mode", "auto", {"auto", "block", "cube", "object", "particles"})
              .doc_(
                  "block: a corner is cut out, which shows inner faces; cube: a whole block; object: carved "
                  "from the solid; particles: without binder; auto: object where one is connected, else "
                  "block, "
                  "else particles"))
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
