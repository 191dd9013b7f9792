#include "graph/node_type.h"
#include "nodes/common/io/stroke_text.h"
#include "runtime/context.h"

namespace terrazzo::strokes {
namespace {

void compute(Context& c) {
  Strokes out;
  for (const auto& text : c.texts("strokes")) {
    try {
      out.strokes.push_back(read_stroke(text));
    } catch (Error& e) {
      throw e.parameter("strokes");
    }
  }
  c.output("strokes", std::move(out));
}

}  // namespace
}  // namespace terrazzo::strokes

namespace terrazzo {

NodeType strokes_node() {
  using namespace strokes;
  return NodeType("Strokes", 1)
      .doc_("Defines strokes in the graph, for TextureNib")
      .output("strokes", "Strokes", "Strokes in the order written")
      .parameter(Parameter::texts("strokes", {})
                     .required()
                     .unit_("pixels")
                     .doc_("One line or area per stroke: \"radius: x y, x y, …\" or \"area: x y, x y, x y\". "
                           "More outlines of an area follow after semicolons. Points count from the "
                           "picture's upper left corner, y down."))
      .compute_(compute);
}

}  // namespace terrazzo
