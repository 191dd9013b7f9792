#include "graph/node_type.h"
#include "nodes/photograph/blend/blend.h"
#include "runtime/context.h"

namespace terrazzo::blend {
namespace {

void compute(Context& c) {
  const Mask mask{c.optional<Image>("mask"), c.optional<Labels>("mask")};
  c.output("image", blend_images(c.input<Image>("image"), c.input<Image>("over"), mask,
                                 c.choice<Mode>("mode"), c.number("amount"), c.work()));
}

}  // namespace
}  // namespace terrazzo::blend

namespace terrazzo {

NodeType blend_node() {
  using namespace blend;
  return NodeType("Blend", 1)
      .doc_("Blends one picture over another of the same size")
      .source_("W3C Compositing and Blending Level 1")
      .input("image", "Image", "Picture below")
      .input("over", "Image", "Picture above: as many sections, or one")
      .optional_input(
          "mask", {"Image", "Labels"},
          "Where the upper picture shows: as bright as an image is, from 0 to 1, or on particles. "
          "Without it, everywhere.")
      .output("image", "Image", "Blended picture")
      .parameter(Parameter::choice("mode", "mix",
                                   {"mix", "multiply", "screen", "overlay", "add", "subtract", "difference"})
                     .doc_("How values are joined. They are scene-linear; those below 0 become 0."))
      .parameter(Parameter::number("amount", 1).range(0, 1).doc_("Share of the upper picture"))
      .compute_(compute);
}

}  // namespace terrazzo
