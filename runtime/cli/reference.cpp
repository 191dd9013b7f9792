#include "runtime/cli/reference.h"

#include <fmt/format.h>

#include <iostream>
#include <map>
#include <optional>

#include "graph/describe.h"
#include "runtime/cli/write_value.h"
#include "runtime/files.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

// What there is to see of a node in its example: its own picture, else the last picture made downstream of
// it.
std::optional<Wire> picture_of(const Graph& g, const NodeType& type) {
  std::optional<Wire> found;
  std::vector<bool> downstream(g.nodes.size(), false);
  for (std::size_t i = 0; i < g.nodes.size(); ++i) {
    const GraphNode& node = g.nodes[i];
    const bool own = node.type == &type;
    downstream[i] = own;
    for (const auto& [port, wires] : node.inputs)
      for (const auto& w : wires)
        downstream[i] = downstream[i] || downstream[static_cast<std::size_t>(w.node)];
    if (!downstream[i]) continue;
    for (const char* kind : {"Image", "Labels"})
      for (const auto& port : node.type->outputs)
        if (port.types[0] == kind) {
          const Wire here{static_cast<int>(i), port.name, {}};
          if (own) return here;
          if (!found || std::string(kind) == "Image") found = here;
        }
  }
  return found;
}

// The example of a type: the graph beside it that uses it. Folders are named after the types, ShapeEstimate
// in shape_estimate.
std::optional<fs::path> example_of(const NodeType& type, const fs::path& examples) {
  const auto plain = [](std::string s) {
    std::erase(s, '_');
    for (char& c : s) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return s;
  };
  std::error_code error;
  for (const auto& e : fs::directory_iterator(examples, error))
    if (plain(e.path().filename().string()) == plain(type.name) && fs::exists(e.path() / "example.yaml"))
      return e.path() / "example.yaml";
  return {};
}

void write_picture(const Program& program, Graph graph, Wire wire, const fs::path& file,
                   const GraphOptions& o) {
  if (const NodeType* sheet = program.registry().find("ContactSheet")) {  // brings every picture to one size
    GraphNode node;
    node.path = "(sheet)", node.type = sheet;
    node.inputs["images"] = {wire};
    node.parameters["cell"] = {std::int64_t{400}, {}, "400"};
    graph.nodes.push_back(std::move(node));
    wire = {static_cast<int>(graph.nodes.size()) - 1, "image", {}};
  }
  SessionOptions session_options_of = session_options(o);
  Session session(program.registry(), program.types(), session_options_of);
  RunOptions options;
  options.targets = {append_writer(program.registry(), graph, wire, file)};
  options.output_folder = file.parent_path();
  options.cancel = session_options_of.cancel;
  const RunResult r = session.evaluator().run(graph, options);
  if (r.cancelled()) throw Cancelled();
  for (const auto& n : r.nodes)
    if (n.error) throw Error(*n.error);
}

}  // namespace

void write_reference(const Program& program, const fs::path& folder, const fs::path& examples, bool pictures,
                     const GraphOptions& o) {
  std::string index =
      "# Node types\n\nWritten by `./dev docs` from the declarations; `terrazzo nodes TYPE` prints the "
      "same.\n\n"
      "| type | |\n|---|---|\n";
  for (const NodeType* type : program.registry().all()) {
    index += fmt::format("| [{0}]({0}.md) | {1} |\n", type->name, type->doc);
    std::string page = describe_markdown(*type);
    if (const auto example = example_of(*type, examples)) {
      Diagnostics found;
      const Graph graph = load_graph(*example, program.registry(), {}, found);
      if (has_errors(found)) throw Error(found.front());
      page += "\n## Example\n\n```yaml\n" + read_file(*example).value_or("") + "```\n";
      if (const auto wire = picture_of(graph, *type)) {
        page += fmt::format("\n![{0}](images/{0}.png)\n", type->name);
        if (pictures) {
          std::cerr << type->name << '\n';
          write_picture(program, graph, *wire, folder / "images" / (type->name + ".png"), o);
        }
      }
    }
    write_text_atomically(folder / (type->name + ".md"), page);
  }
  write_text_atomically(folder / "README.md", index);
}

}  // namespace terrazzo::cli
