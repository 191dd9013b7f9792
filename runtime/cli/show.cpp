#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/cli/commands.h"
#include "runtime/cli/progress.h"
#include "runtime/cli/report.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

struct ShowOptions : GraphOptions {
  std::string target, file;
  bool json = false;
};

// Writes the value by a node type that can write any: the one mechanism by which values become files.
void append_writer(const Registry& registry, Graph& graph, const Wire& wire, const fs::path& file,
                   RunOptions& options) {
  for (const NodeType* type : registry.all()) {
    if (!type->writes_files || !type->find_parameter("path")) continue;
    const std::string& value_type =
        graph.nodes[static_cast<std::size_t>(wire.node)].type->find_output(wire.port)->types[0];
    const Port* port = nullptr;
    for (const auto& p : type->inputs)
      if (p.accepts(value_type) && (!port || port->types.empty())) port = &p;
    if (!port) continue;
    GraphNode node;
    node.path = "(show)";
    node.type = type;
    node.place = {"command line (-o)", 0, 0};
    node.inputs[port->name] = {wire};
    node.parameters["path"] = {ParameterValue(file.filename().string()), node.place, file.string()};
    graph.nodes.push_back(std::move(node));
    options.targets = {static_cast<int>(graph.nodes.size()) - 1};
    options.output_folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    return;
  }
  throw Error("usage", "no node type of this program writes such a value to a file");
}

int show(const Program& program, const ShowOptions& o) {
  Graph graph;
  if (!open_graph(program, o, graph)) return wrong_usage;
  const Wire wire = graph.wire_to(o.target);
  RunOptions options;
  options.targets = {wire.node};
  options.threads = o.threads;
  options.cancel = cancel_on_interrupt();
  options.provenance = provenance(graph, o, program.registry);
  if (!o.file.empty()) append_writer(program.registry, graph, wire, o.file, options);
  Cache cache(program, o);
  Evaluator evaluator(program.types, cache.store, cache.hashes);
  RunResult result;
  {
    const auto needed = needed_nodes(graph, options.targets);
    ProgressLine line(graph, static_cast<std::size_t>(std::count(needed.begin(), needed.end(), true)),
                      o.quiet);
    options.observer = &line;
    result = evaluator.run(graph, options);
  }
  if (result.cancelled()) return interrupted;
  if (result.failed()) return node_failed;
  if (!o.file.empty()) return done;
  const Value v = evaluator.value(graph, result, wire);
  const nlohmann::json described = v.type().describe(v.data());
  if (o.json)
    std::cout << described.dump(2) << '\n';
  else
    std::cout << v.type().name << '\n' << readable(v.type().name, described);
  return done;
}

}  // namespace

void add_show(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("show", "Evaluate one output and print it");
  auto o = std::make_shared<ShowOptions>();
  add_graph_options(*command, *o);
  command->add_option("output", o->target, "NODE.PORT, or an output of the graph")->required();
  add_cache_options(*command, *o);
  command->add_flag("--json", o->json, "Print JSON");
  command->add_flag("--quiet", o->quiet, "Errors only");
  command->add_option("-o,--output", o->file, "Write it to this file instead");
  command->callback([o, &program, &exit_code] { exit_code = show(program, *o); });
}

}  // namespace terrazzo::cli
