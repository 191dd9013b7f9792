#include "graph/node_type.h"
#include "nodes/photograph/grain/grain.h"
#include "runtime/context.h"

namespace terrazzo::grain {
namespace {

void compute(Context& c) {
  const GrainOptions g{c.number("mottle"), c.number("vary"),  c.number("scale"),
                       c.number("blur"),   c.number("noise"), c.seed()};
  c.output("image", add_grain(c.input<Image>("image"), c.optional<Labels>("labels"), g, c.work()));
}

}  // namespace
}  // namespace terrazzo::grain

namespace terrazzo {

NodeType grain_node() {
  using namespace grain;
  return NodeType("Grain", 1)
      .doc_("Makes a drawn section look photographed: mottles particles and adds a camera's blur and noise")
      .input("image", "Image", "Picture of a section")
      .optional_input("labels", {"Labels"}, "Particle of each pixel. Each particle gets its own pattern.")
      .output("image", "Image", "Picture of the same size")
      .parameter(Parameter::number("mottle", 0.15)
                     .range(0, 1)
                     .doc_("Relative standard deviation of the brightness within a particle"))
      .parameter(Parameter::number("vary", 0.05)
                     .range(0, 1)
                     .doc_("Relative standard deviation of the color channels between particles"))
      .parameter(
          Parameter::number("scale", 1).unit_("mm").range(1e-9, 1e9).doc_("Size of the largest mottles"))
      .parameter(Parameter::number("blur", 0.7)
                     .unit_("pixels")
                     .range(0, 50)
                     .doc_("Standard deviation of the lens blur"))
      .parameter(Parameter::number("noise", 0.01)
                     .range(0, 1)
                     .doc_("Standard deviation of a pixel's noise at mid gray, in linear values. It grows as "
                           "√brightness."))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
