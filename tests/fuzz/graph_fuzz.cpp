// Fuzzes graph files. No text causes a crash, and a loaded graph can be written and loaded again.
#include <cstdlib>

#include "graph/document/write_graph.h"
#include "nodes/register_nodes.h"

using namespace terrazzo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Registry registry = [] {
    Registry r;
    register_nodes(r);
    return r;
  }();
  Diagnostics found;
  const Graph g = load_graph_text(std::string(reinterpret_cast<const char*>(data), size),
                                  "/nowhere/fuzz.yaml", registry, {}, found);
  if (has_errors(found)) return 0;
  Diagnostics again;
  const Graph h = load_graph_text(write_graph(g), "/nowhere/fuzz.yaml", registry, {}, again);
  // The exception: a value that contains "${" is read as a parameter reference the second time.
  for (const auto& d : again)
    if (d.severity == Severity::Error && d.code != "unknown-parameter") std::abort();
  if (!has_errors(again) && h.nodes.size() != g.nodes.size()) std::abort();
  return 0;
}
