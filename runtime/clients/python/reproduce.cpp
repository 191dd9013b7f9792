// Graphs from the provenance of files.
#include <fmt/format.h>

#include "graph/describe.h"
#include "graph/document/write_graph.h"
#include "nodes/common/io/provenance.h"
#include "nodes/register_nodes.h"
#include "runtime/clients/cli/made.h"
#include "runtime/clients/python/graph_object.h"
#include "runtime/json_text.h"

namespace terrazzo::python {
namespace {

// Opens the graph that made a file. Returns the action keys of its nodes, and the files that it reads.
py::tuple open_made(GraphObject& into, const std::string& file, const std::vector<std::string>& allow_read) {
  // The file may come from a stranger, so its graph may use built-in nodes only, as `terrazzo reproduce`
  // does.
  Registry built_in;
  register_nodes(built_in);
  register_given_types(built_in, value_types());
  const cli::Made made = cli::how_made(file, value_types(), read_provenance);
  Diagnostics found;
  const Graph graph = cli::open_made(built_in, made, file, {}, allow_read, found);
  if (has_errors(found)) raise(found);
  py::list reads;
  for (const auto& read : cli::reads_of(graph, made, allow_read)) {
    if (!read.allowed())
      throw Error("usage",
                  fmt::format("the graph would read '{}', which is not the file it was made from",
                              read.file.string()),
                  "if you trust it, allow its folder: allow_read=[…]");
    reads.append(read.file.string());
  }
  into.open_text(write_graph(graph), "");
  return py::make_tuple(made.keys, reads);
}

}  // namespace

void bind_reproduce(py::module_& m) {
  m.def("open_made", open_made);
  m.def("describe_graph_file", [](const std::string& file) {
    Diagnostics found;
    const Graph graph = load_graph(file, registry(), {}, found);
    std::erase_if(found, [](const Diagnostic& d) { return d.code == "missing-parameter"; });
    if (has_errors(found)) raise(found);
    return from_json(json_text(describe_json(describe_graph(graph))));
  });
}

}  // namespace terrazzo::python
