#include "graph/node_type.h"
#include "nodes/bodies/carve/carve.h"
#include "nodes/bodies/carving/forms.h"
#include "nodes/data/particles.h"
#include "runtime/context.h"

namespace terrazzo::carve {
namespace {

carving::BodyParts parts_of(const Context& c, carving::Mode mode, const carving::Body& body,
                            const Shape* object) {
  using carving::Mode;
  if (mode == Mode::Fracture)
    return carving::fracture_parts(c.input<Particles>("particles"), c.input<Shapes>("shapes"),
                                   c.number("level"), c.number("roughness"), c.seed());
  if (object) return carving::object_parts(*object, body.voids);
  if (mode == Mode::Vase) return carving::object_parts(carving::vase_form(), body.voids);
  if (mode == Mode::Knot) return carving::object_parts(carving::knot_form(), body.voids);
  return carving::block_parts(body.paint->period(), mode == Mode::Block ? c.number("cut") : 0, body.voids);
}

void carve_body(Context& c) {
  auto mode = c.choice<carving::Mode>("mode");
  if (mode == carving::Mode::Auto) mode = c.has("object") ? carving::Mode::Object : carving::Mode::Block;
  const carving::Body body = body_of(c, mode, c.seed());
  const Shape* object = mode == carving::Mode::Object ? &carving::object_of(c, false) : nullptr;
  CarveOptions options;
  options.edge = c.optional_number("edge").value_or(0);
  options.texture = c.integer("texture");
  options.memory = c.memory();
  CarvedMesh out = carve_mesh(parts_of(c, mode, body, object), body, options, c.work().part(0.05, 1));
  c.metric("edge", out.edge);
  c.metric("triangles", out.shape.mesh.triangles.size());
  c.metric("volume", out.shape.volume);
  c.metric("surface_area", out.shape.surface_area);
  Shapes shapes;
  shapes.shapes.push_back(std::move(out.shape));
  c.output("shapes", std::move(shapes));
  c.output("volume", std::move(out.volume));
  c.output("texture", std::move(out.texture));
}

}  // namespace
}  // namespace terrazzo::carve

namespace terrazzo {

NodeType carve_node() {
  using namespace carve;
  NodeType type("Carve", 5);
  type.doc_(
          "Carves a body from the solid, or breaks a block along its particles, and returns it as a closed "
          "mesh with colors and as a level set, for use in other programs")
      .source_("Jagnow, Dorsey, Rushmeier 2004, figures 1 and 11; 2008, figure 1b");
  carving::declare_solid(type);
  const std::vector<std::string> modes(carving::kModes.begin(), carving::kModes.end() - 1);
  type.output("shapes", "Shapes",
              "The body as one closed mesh with a color per vertex, in mm, with the centroid at the origin")
      .output(
          "volume", "Volume",
          "The body in the same place: `surface`, a level set, and `Cd`, the color of the nearest point of "
          "the surface")
      .output(
          "texture", "Image",
          "The colors at the texture coordinates of the mesh; one pixel of the mean color if texture is 0")
      .parameter(Parameter::choice("mode", "auto", modes)
                     .doc_("block: a block with a corner cut out. cube: a whole block. object: the connected "
                           "mesh. vase, knot: a body of that form. fracture: one period broken across, along "
                           "the particles' surfaces. auto: object if one is connected, else block."));
  carving::declare_body(type);
  return type
      .parameter(
          Parameter::optional_number("edge", "auto")
              .unit_("mm")
              .range(1e-9, 1e9)
              .doc_("Longest edge of a triangle, and edge of a voxel. Colors are as fine as this. auto: "
                    "1/200 of the body's longest side."))
      .parameter(Parameter::integer("texture", 0)
                     .unit_("pixels")
                     .range(0, 16384)
                     .doc_("Edge of a square texture with finer colors than those of the vertices. 0: no "
                           "texture."))
      .parameter(Parameter::seed())
      .check_(carving::check_body)
      .compute_(carve_body);
}

}  // namespace terrazzo
