#include "graph/node_type.h"
#include "nodes/grain/grain.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  const GrainSettings g{c.number("mottle"), c.number("vary"),  c.number("scale"),
                        c.number("blur"),   c.number("noise"), static_cast<std::uint64_t>(c.integer("seed"))};
  c.output("image", add_grain(c.input<Image>("image"), c.optional<Labels>("labels"), g, c.work()));
}

}  // namespace

NodeType grain_node() {
  return NodeType("Grain", 1)
      .doc_(
          "Mottles particles and adds a camera's blur and noise, so that a drawn section looks photographed")
      .input("image", "Image", "picture of a section")
      .optional_input("labels", {"Labels"}, "the particle of each pixel: each gets a pattern of its own")
      .output("image", "Image", "picture of the same size")
      .parameter(Parameter::number("mottle", 0.15)
                     .range(0, 1)
                     .doc_("Standard deviation of the brightness within a particle, relative"))
      .parameter(Parameter::number("vary", 0.05)
                     .range(0, 1)
                     .doc_("Standard deviation of a particle's colour channels, relative"))
      .parameter(Parameter::number("scale", 1).unit_("mm").above(0).doc_("Size of the largest mottles"))
      .parameter(Parameter::number("blur", 0.7)
                     .unit_("pixels")
                     .range(0, 50)
                     .doc_("Standard deviation of the lens's blur"))
      .parameter(Parameter::number("noise", 0.01)
                     .range(0, 1)
                     .doc_("Standard deviation of a pixel's noise at mid grey, linear; grows as √brightness"))
      .parameter(Parameter::integer("seed", 1).range(0, 9007199254740991).doc_("Of mottles and noise"))
      .compute_(compute);
}

}  // namespace terrazzo
