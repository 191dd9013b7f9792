#include "graph/node_type.h"
#include "nodes/solids/pattern/pattern.h"
#include "runtime/context.h"

namespace terrazzo::pattern {
namespace {

void compute(Context& c) {
  PatternOptions p;
  p.kind = c.choice<Kind>("kind");
  p.axis = c.choice<int>("axis");
  p.offset = c.number("offset");
  p.width = c.integer("width");
  p.height = c.integer("height");
  p.pixel_size = c.number("pixel_size");
  p.scale = c.number("scale");
  p.seed = c.seed();
  c.output("image", pattern_image(p, c.work()));
}

}  // namespace
}  // namespace terrazzo::pattern

namespace terrazzo {

NodeType pattern_node() {
  using namespace pattern;
  return NodeType("Pattern", 1)
      .doc_(
          "Draws a section through a procedural material made of noise, as an exemplar that needs no "
          "photograph")
      .source_("Gradient noise: Perlin 2002; cells: Worley 1996")
      .output("image", "Image", "Section in scene-linear color")
      .parameter(Parameter::choice(
                     "kind", "wood",
                     {"wood", "marble", "muscle", "fat", "bone", "sandstone", "electrode", "copolymer"})
                     .doc_("Material. Wood and muscle have fibers along z; marble has veins, fat has "
                           "lobules, bone has struts. Sandstone, electrode and copolymer are gray, with two, "
                           "three and two "
                           "phases."))
      .parameter(Parameter::choice("axis", "x", {"x", "y", "z"})
                     .doc_("Axis normal to the section. On x and y, z is up."))
      .parameter(Parameter::number("offset", 0)
                     .range(-1e6, 1e6)
                     .unit_("mm")
                     .doc_("Position of the section along the axis"))
      .parameter(
          Parameter::integer("width", 128).range(1, 16384).unit_("pixels").doc_("Width of the picture"))
      .parameter(
          Parameter::integer("height", 128).range(1, 16384).unit_("pixels").doc_("Height of the picture"))
      .parameter(Parameter::number("pixel_size", 0.1).range(1e-9, 1e9).unit_("mm").doc_("Edge of a pixel"))
      .parameter(Parameter::number("scale", 2)
                     .range(1e-9, 1e9)
                     .unit_("mm")
                     .doc_("Width of a ring, distance of veins or struts, diameter of a bundle, lobule or "
                           "grain, or period of "
                           "a copolymer"))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
