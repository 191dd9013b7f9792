#include "graph/node_type.h"
#include "nodes/common/io/json_input.h"
#include "nodes/shapes/load_shapes/read_shapes.h"
#include "runtime/context.h"

namespace terrazzo::load_shapes {
namespace {

void compute(Context& c) {
  Shapes shapes = read_shapes(json_text_in(c), c.files("path")[0].string(), c.work());
  double triangles = 0;
  for (const Shape& s : shapes.shapes) triangles += s.mesh.triangles.size();
  c.metric("shapes", shapes.shapes.size());
  c.metric("triangles", triangles);
  c.output("shapes", std::move(shapes));
}

}  // namespace
}  // namespace terrazzo::load_shapes

namespace terrazzo {

NodeType load_shapes_node() {
  using namespace load_shapes;
  return NodeType("LoadShapes", 1)
      .doc_(
          "Reads a set of shapes that Export wrote to .json, with probabilities, classes, colors and "
          "measures, without loss of precision. LoadMesh reads meshes of other programs.")
      .output("shapes", "Shapes", "The shapes, in the order of the file")
      .parameter(Parameter::input_path("path").doc_("JSON file of shapes"))
      .compute_(compute);
}

}  // namespace terrazzo
