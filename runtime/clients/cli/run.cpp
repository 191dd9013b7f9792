#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "graph/text/utf8.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/default_graph.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/progress.h"
#include "runtime/clients/cli/report.h"
#include "runtime/clients/cli/slurm/run_elements.h"
#include "runtime/clients/cli/slurm/slurm_detached.h"
#include "runtime/files.h"
#include "runtime/files/protected_files.h"
#include "runtime/json_text.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

struct RunCommand : GraphOptions {
  std::string report;
  bool dry_run = false;
  SlurmOptions slurm;
};

// Prints the graph outputs that are tables. In the material graphs these compare the solid with the
// photograph.
void print_output_tables(Evaluator& evaluator, const Graph& graph, const RunResult& result) {
  for (const auto& o : graph.outputs) {
    const auto& node = result.nodes[o.wire.node];
    const auto it = node.outputs.find(o.wire.port);
    if (it == node.outputs.end() || it->second.type != "Table") continue;
    const Value v = evaluator.value(graph, result, o.wire);
    std::cout << '\n' << escape_line(o.name) << ":\n" << readable("Table", v.type().describe(v.data()));
  }
}

void choose_default_graph(RunCommand& o) {
  o.graph = default_graph().string();
  if (o.graph.empty())
    throw Error("usage", "no graph is given, and the default graph is not installed with this program",
                "name a graph file: terrazzo run GRAPH");
  if (!o.quiet) std::cout << "no graph given: using " << o.graph << "; output folder: " << o.out << std::endl;
}

// Where the report may go: to the file that is named, or to the output folder if the run writes files there.
// Checked before the run, so that no work is lost.
fs::path place_of_report(const RunCommand& o, const Graph& graph, const ProtectedFiles& keep) {
  const auto needed = needed_nodes(graph, o.targets.empty() ? graph.sinks() : target_nodes(graph, o.targets));
  ProtectedFiles written;
  bool writes = false;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const GraphNode& node = graph.nodes[i];
    if (!needed[i] || !node.type->writes_files) continue;
    writes = true;
    for (const auto& p : node.type->parameters)
      if (const auto it = node.parameters.find(p.name);
          p.kind == ParameterKind::OutputPath && it != node.parameters.end())
        written.add(fs::path(o.out) / std::get<std::string>(it->second.value),
                    "which '" + node.path + "' writes");
  }
  if (o.report.empty() && !writes) return {};
  const fs::path report = o.report.empty() ? fs::path(o.out) / "report.json" : fs::path(o.report);
  keep.require_other(report);
  written.require_other(report);
  require_replaceable(report);
  return report;
}

void write_report(const RunCommand& o, const fs::path& report, ProtectedFiles keep, Session& session,
                  const RunResult& result) {
  bool wrote = false;
  for (const auto& node : result.nodes)
    for (const auto& f : node.files) {
      keep.add(fs::path(o.out) / f.path, "which this run has written");
      wrote = true;
    }
  if (o.report.empty() && !wrote) return;
  const auto json =
      report_json(*session.graph(), result, threads(o), session.overrides(), report.parent_path());
  write_text_atomically(report, keep, json_text(json, 2) + "\n");
}

int run(const Program& program, RunCommand& o) {
  complete_slurm_options(o.slurm, o);
  const NodeSet& nodes = program.nodes();  // loaded first: session_options checks the address space left
  Session session(nodes.registry, nodes.types, session_options(o));
  if (!open_graph(session, o)) return kWrongUsage;
  const Graph& graph = *session.graph();
  if (o.dry_run) {
    print_plan(session, o, false);
    return kDone;
  }
  const ProtectedFiles keep(graph);
  const fs::path report = place_of_report(o, graph, keep);
  if (o.slurm.on_slurm())
    if (const auto code = run_elements(session, o, o.slurm)) return *code;
  ProgressLine line(session, target_nodes(graph, o.targets), o.quiet);
  const auto evaluation = session.evaluate(o.targets, &line);
  const RunResult& result = evaluation->wait();
  line.close();
  if (result.without_result) print(result.errors());  // so far they were warnings
  if (!result.trouble.empty()) std::cerr << "warning: " << result.trouble << '\n';
  if (!o.quiet) {
    print_table(std::cout, graph, result);
    print_metrics(std::cout, graph, result);
    print_stacks(std::cout, graph, result);
    if (!result.cancelled()) print_output_tables(session.evaluator(), graph, result);
    for (const auto& node : result.nodes)
      for (const auto& f : node.files) std::cout << "wrote " << (fs::path(o.out) / f.path).string() << '\n';
  }
  finish(session, o);
  if (!report.empty()) write_report(o, report, keep, session, result);
  if (result.cancelled()) {
    std::cerr << "interrupted; finished nodes are cached\n";
    return kInterrupted;
  }
  return result.failed() ? kNodeFailed : kDone;
}

}  // namespace

void add_run(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("run", "Evaluate a graph");
  auto o = std::make_shared<RunCommand>();
  auto* graph =
      add_graph_options(*command, *o)
          ->required(false)
          ->description(
              "Graph file (YAML; default: the terrazzo material that is installed with the program)");
  add_run_options(*command, *o);
  add_target_option(*command, *o, "evaluate");
  command
      ->add_option("--report", o->report,
                   "Write a JSON report to this file (default: report.json in the output folder, if the "
                   "run wrote files there)")
      ->type_name(placeholder::file);
  add_slurm_options(*command, o->slurm, "elements of repeated nodes");
  command->add_flag("--dry-run", o->dry_run,
                    "Show which nodes would run and how long they took before, without running them");
  command->add_flag("--quiet", o->quiet, "Print errors only");
  command->callback([o, graph, &program, &exit_code] {
    if (graph->count() == 0) choose_default_graph(*o);
    exit_code = run_as_job(*o, o->slurm, [&] { return run(program, *o); });
  });
}

void add_texture(CLI::App& app, const Program& program, int& exit_code) {
  struct TextureCommand : RunCommand {
    std::string photo, pixel_size, resolution, finish;  // parameters of graphs/materials/texture_set.yaml
  };
  auto* command = app.add_subcommand("texture", "Make texture maps that tile from a photograph");
  auto o = std::make_shared<TextureCommand>();
  command->add_option("photo", o->photo, "Photograph of a section")
      ->type_name(placeholder::image)
      ->required();
  command
      ->add_option("--pixel-size", o->pixel_size,
                   "Edge length of a pixel of the photograph in mm (default: 0.1)")
      ->type_name(placeholder::number);
  command
      ->add_option("--resolution", o->resolution, "Pixels along the longer edge of the maps (default: 2048)")
      ->type_name(placeholder::number);
  command
      ->add_option("--finish", o->finish, "polished, honed, weathered, broken or loose (default: polished)")
      ->type_name("FINISH");
  command->add_option("--param", o->parameters, "Set another parameter of the graph: NAME=VALUE (repeatable)")
      ->type_name(placeholder::graph_setting)
      ->take_all()
      ->expected(1);
  add_set_option(*command, *o);
  add_run_options(*command, *o);
  command->add_flag("--dry-run", o->dry_run, "Show which nodes would run, without running them");
  command->add_flag("--quiet", o->quiet, "Print errors only");
  command->callback([o, &program, &exit_code] {
    o->graph = installed_graph("materials/texture_set.yaml").string();
    o->parameters.push_back("photo=" + fs::absolute(o->photo).string());
    for (const auto& [name, value] :
         {std::pair("pixel_size", &o->pixel_size), std::pair("resolution", &o->resolution),
          std::pair("finish", &o->finish)})
      if (!value->empty()) o->parameters.push_back(std::string(name) + "=" + *value);
    exit_code = run(program, *o);
  });
}

}  // namespace terrazzo::cli
