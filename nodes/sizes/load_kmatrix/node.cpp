#include "graph/node_type.h"
#include "nodes/common/io/json_input.h"
#include "nodes/sizes/load_kmatrix/read_kmatrix.h"
#include "runtime/context.h"

namespace terrazzo::load_kmatrix {
namespace {

void compute(Context& c) {
  KMatrix k = read_kmatrix(json_text_in(c), c.files("path")[0].string());
  c.metric("shapes", k.shapes.size());
  c.metric("classes", k.classes);
  c.output("kmatrix", std::move(k));
}

}  // namespace
}  // namespace terrazzo::load_kmatrix

namespace terrazzo {

NodeType load_kmatrix_node() {
  using namespace load_kmatrix;
  return NodeType("LoadKMatrix", 1)
      .doc_("Reads a K matrix that Export wrote to .json, without loss of precision.")
      .output("kmatrix", "KMatrix", "The K matrix of each shape")
      .parameter(Parameter::input_path("path").doc_("JSON file of a K matrix"))
      .compute_(compute);
}

}  // namespace terrazzo
