#include "graph/node_type.h"
#include "nodes/pattern/pattern.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  pattern::PatternChoice p;
  p.kind = c.text("kind"), p.axis = c.text("axis"), p.offset = c.number("offset");
  p.width = static_cast<int>(c.integer("width")), p.height = static_cast<int>(c.integer("height"));
  p.pixel_size = c.number("pixel_size"), p.scale = c.number("scale");
  p.seed = static_cast<std::uint64_t>(c.integer("seed"));
  c.output("image", pattern::pattern_image(p, c.work()));
}

}  // namespace

NodeType pattern_node() {
  return NodeType("Pattern", 1)
      .doc_("A section through a material made up of noise: an exemplar that needs no photograph")
      .source_("Gradient noise: Perlin 2002; cells: Worley 1996")
      .output("image", "Image", "the section, scene-linear")
      .parameter(
          Parameter::choice("kind", "wood", {"wood", "marble", "muscle", "fat", "bone"})
              .doc_("wood and muscle have their fibres along z; marble has veins, fat lobules, bone struts"))
      .parameter(Parameter::choice("axis", "x", {"x", "y", "z"})
                     .doc_("The axis that the section lies across; on x and y, z is up"))
      .parameter(
          Parameter::number("offset", 0).range(-1e6, 1e6).unit_("mm").doc_("Of the section along the axis"))
      .parameter(Parameter::integer("width", 128).range(1, 16384).unit_("pixels").doc_("Of the picture"))
      .parameter(Parameter::integer("height", 128).range(1, 16384).unit_("pixels").doc_("Of the picture"))
      .parameter(Parameter::number("pixel_size", 0.1).above(0).unit_("mm").doc_("Edge of a pixel"))
      .parameter(
          Parameter::number("scale", 2)
              .above(0)
              .unit_("mm")
              .doc_("A ring's width, the distance of veins or struts, the diameter of a bundle or lobule"))
      .parameter(Parameter::integer("seed", 1).range(0, 9007199254740991).doc_("Of the noise"))
      .compute_(compute);
}

}  // namespace terrazzo
