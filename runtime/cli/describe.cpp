// graph, nodes, schema: what can be told without computing.
#include "graph/describe.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "graph/nearest.h"
#include "runtime/cli/commands.h"

namespace terrazzo::cli {

void add_graph(CLI::App& app, const Program& program, int& exit_code) {
  struct Options : GraphOptions {
    std::string format = "dot";
  };
  auto* command = app.add_subcommand("graph", "Draw the graph");
  auto o = std::make_shared<Options>();
  add_graph_options(*command, *o);
  command->add_option("--format", o->format, "dot, svg or mermaid")
      ->check(CLI::IsMember({"dot", "svg", "mermaid"}))
      ->capture_default_str();
  command->callback([o, &program, &exit_code] {
    Session session(program.registry, program.types);
    if (!open_graph(session, *o)) {
      exit_code = wrong_usage;
      return;
    }
    const Graph& graph = *session.graph();
    std::cout << (o->format == "svg"       ? draw_svg(graph)
                  : o->format == "mermaid" ? draw_mermaid(graph)
                                           : draw_dot(graph));
  });
}

void add_nodes(CLI::App& app, const Program& program, int& exit_code) {
  struct Options {
    std::string type;
    bool json = false, markdown = false;
  };
  auto* command = app.add_subcommand("nodes", "List node types, or describe one");
  auto o = std::make_shared<Options>();
  command->add_option("type", o->type, "Node type");
  auto* json = command->add_flag("--json", o->json, "As JSON");
  command->add_flag("--markdown", o->markdown, "As Markdown")->excludes(json);
  command->callback([o, &program, &exit_code] {
    std::vector<const NodeType*> types = program.registry.all();
    if (!o->type.empty()) {
      const NodeType* t = program.registry.find(o->type);
      if (!t) {
        std::cerr << "error: there is no node type '" << o->type << "'"
                  << did_you_mean(o->type, program.registry.names()) << '\n';
        exit_code = wrong_usage;
        return;
      }
      types = {t};
    }
    if (o->json) {
      nlohmann::json all = nlohmann::json::array();
      for (const auto* t : types) all.push_back(describe_json(*t));
      std::cout << (o->type.empty() ? all : all[0]).dump(2) << '\n';
    } else if (o->markdown || !o->type.empty()) {
      for (const auto* t : types)
        std::cout << (o->markdown ? describe_markdown(*t) : describe_text(*t)) << '\n';
    } else {
      for (const auto* t : types) std::cout << fmt::format("{:<16} {}\n", t->name, t->doc);
    }
  });
}

void add_schema(CLI::App& app, const Program& program, int&) {
  auto* command = app.add_subcommand("schema", "Print the JSON Schema of graph files");
  command->callback([&program] { std::cout << graph_schema(program.registry).dump(2) << '\n'; });
}

}  // namespace terrazzo::cli
