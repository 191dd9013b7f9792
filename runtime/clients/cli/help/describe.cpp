// The commands graph, nodes and schema, which compute nothing.
#include "graph/describe.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "graph/text/nearest.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/help/reference.h"
#include "runtime/clients/cli/placeholders.h"

namespace terrazzo::cli {

void add_graph(CLI::App& app, const Program& program, int& exit_code) {
  struct Options : GraphOptions {
    std::string format = "dot";
  };
  auto* command = app.add_subcommand("graph", "Print a drawing of a graph");
  auto o = std::make_shared<Options>();
  add_graph_options(*command, *o);
  command->add_option("--format", o->format, "Output format: dot, svg or mermaid")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"dot", "svg", "mermaid"}))
      ->capture_default_str();
  command->callback([o, &program, &exit_code] {
    Session session(program.registry(), program.types());
    if (!open_graph(session, *o)) {
      exit_code = kWrongUsage;
      return;
    }
    const Graph& graph = *session.graph();
    std::cout << (o->format == "svg"       ? draw_svg(graph)
                  : o->format == "mermaid" ? draw_mermaid(graph)
                                           : draw_dot(graph));
  });
}

namespace {

struct NodesCommand : GraphOptions {
  std::string type, out, examples;
  bool json = false, markdown = false, pictures = false;
};

// Describes a graph file like a node type: its inputs, outputs and parameters.
std::optional<NodeType> graph_as_type(const Program& program, const std::string& file) {
  Diagnostics found;
  const Graph graph = load_graph(file, program.registry(), {}, found);
  // A graph made for use as a subgraph may leave required parameters and inputs to its user.
  std::erase_if(
      found, [](const Diagnostic& d) { return d.code == "missing-parameter" || d.code == "missing-input"; });
  print(found);
  if (has_errors(found)) return {};
  return describe_graph(graph);
}

int nodes(const Program& program, const NodesCommand& o) {
  if (!o.out.empty()) {
    write_reference(program, o.out, o.examples, o.pictures, o);
    return kDone;
  }
  std::vector<const NodeType*> types = program.registry().all();
  std::optional<NodeType> graph;
  if (const auto extension = std::filesystem::path(o.type).extension();
      extension == ".yaml" || extension == ".yml") {
    graph = graph_as_type(program, o.type);
    if (!graph) return kWrongUsage;
    types = {&*graph};
  } else if (!o.type.empty()) {
    const NodeType* t = program.registry().find(o.type);
    if (!t) {
      std::cerr << "error: there is no node type '" << o.type << "'"
                << did_you_mean(o.type, program.registry().names()) << '\n';
      return kWrongUsage;
    }
    types = {t};
  }
  if (o.json) {
    nlohmann::json all = nlohmann::json::array();
    for (const auto* t : types) all.push_back(describe_json(*t));
    std::cout << (o.type.empty() ? all : all[0]).dump(2) << '\n';
  } else if (o.markdown || !o.type.empty()) {
    for (const auto* t : types) std::cout << (o.markdown ? describe_markdown(*t) : describe_text(*t)) << '\n';
  } else {
    for (const auto& district : program.registry().by_district()) {
      std::cout << district.name << '\n';
      for (const auto* t : district.types) std::cout << fmt::format("  {:<16} {}\n", t->name, t->doc);
    }
  }
  return kDone;
}

}  // namespace

void add_nodes(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("nodes", "List all node types, or describe a node type or a graph file");
  auto o = std::make_shared<NodesCommand>();
  command->add_option("type", o->type, "Node type or graph file to describe")
      ->type_name(placeholder::node_type);
  auto* json = command->add_flag("--json", o->json, "Print JSON");
  command->add_flag("--markdown", o->markdown, "Print Markdown")->excludes(json);
  auto* out = command->add_option("--out", o->out, "Write a reference page for each node type to this folder")
                  ->type_name(placeholder::folder);
  command
      ->add_option("--examples", o->examples,
                   "Folder with a subfolder per node type that contains its example.yaml")
      ->type_name(placeholder::folder)
      ->needs(out);
  command->add_flag("--pictures", o->pictures, "Run the examples and write their pictures")->needs(out);
  command->callback([o, &program, &exit_code] { exit_code = nodes(program, *o); });
}

void add_schema(CLI::App& app, const Program& program, int&) {
  auto* command = app.add_subcommand("schema", "Print the JSON Schema of graph files");
  command->callback([&program] { std::cout << graph_schema(program.registry()).dump(2) << '\n'; });
}

}  // namespace terrazzo::cli
