#include "graph/node_type.h"
#include "nodes/detail/repaint/repaint.h"
#include "runtime/context.h"

namespace terrazzo::repaint {
namespace {

void compute(Context& c) {
  c.output("image", repaint(c.input<Image>("image"), c.input<Labels>("labels"), c.optional<Detail>("detail"),
                            c.seed(), c.work()));
}

}  // namespace
}  // namespace terrazzo::repaint

namespace terrazzo {

NodeType repaint_node() {
  using namespace repaint;
  return NodeType("Repaint", 3)
      .doc_("Paints a photograph's own profiles and binder in flat colors with synthesized detail")
      .input("image", "Image", "Photograph with one or more sections")
      .input("labels", "Labels", "Profiles of image")
      .optional_input("detail", {"Detail"}, "From DetailSolid. Without it, colors are flat and outlines hard")
      .output("image", "Image", "The repainted photograph, of the same size")
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
