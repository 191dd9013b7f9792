#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/cli/commands.h"
#include "runtime/cli/progress.h"
#include "runtime/cli/report.h"
#include "runtime/files.h"
#include "runtime/json_text.h"

namespace terrazzo::cli {
namespace {

struct RunCommand : GraphOptions {
  std::string report;
  bool dry_run = false;
};

// The graph's own outputs that are tables: how close the result came, told at the end of the run.
void print_output_tables(Evaluator& evaluator, const Graph& graph, const RunResult& result) {
  for (const auto& o : graph.outputs) {
    const auto& node = result.nodes[static_cast<std::size_t>(o.wire.node)];
    const auto it = node.outputs.find(o.wire.port);
    if (it == node.outputs.end() || it->second.type != "Table") continue;
    const Value v = evaluator.value(graph, result, o.wire);
    std::cout << '\n' << o.name << ":\n" << readable("Table", v.type().describe(v.data()));
  }
}

int run(const Program& program, const RunCommand& o) {
  const NodeSet& nodes = program.nodes();  // loaded first: session_options looks at the room that is left
  Session session(nodes.registry, nodes.types, session_options(o));
  if (!open_graph(session, o)) return wrong_usage;
  const Graph& graph = *session.graph();
  if (o.dry_run) {
    print_plan(session, o, false);
    return done;
  }
  ProgressLine line(session, target_nodes(graph, o.targets), o.quiet);
  const auto evaluation = session.evaluate(o.targets, &line);
  const RunResult& result = evaluation->wait();
  line.close();
  if (!result.trouble.empty()) std::cerr << "warning: " << result.trouble << '\n';
  if (!o.quiet) {
    print_table(std::cout, graph, result);
    print_metrics(std::cout, graph, result);
    if (!result.cancelled()) print_output_tables(session.evaluator(), graph, result);
    for (const auto& node : result.nodes)
      for (const auto& f : node.files)
        std::cout << "wrote " << (std::filesystem::path(o.out) / f.path).string() << '\n';
  }
  finish(session, o);
  // Beside the files that a run wrote, unless somebody names another place.
  std::filesystem::path report = o.report;
  for (const auto& node : result.nodes)
    if (report.empty() && !node.files.empty()) report = std::filesystem::path(o.out) / "report.json";
  if (!report.empty())
    write_text_atomically(
        report,
        json_text(report_json(graph, result, threads(o), session.overrides(), report.parent_path()), 2) +
            "\n");
  if (result.cancelled()) {
    std::cerr << "interrupted; what was finished is cached\n";
    return interrupted;
  }
  return result.failed() ? node_failed : done;
}

}  // namespace

void add_run(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("run", "Evaluate what the targets need");
  auto o = std::make_shared<RunCommand>();
  add_graph_options(*command, *o);
  add_run_options(*command, *o);
  command->add_option("--target", o->targets, "NODE or NODE.PORT to evaluate (default: every sink)")
      ->take_all()
      ->expected(1);
  command->add_option("--report", o->report,
                      "Write a JSON report to this file (default: report.json beside the files written)");
  command->add_flag("--dry-run", o->dry_run, "Tell what would run and how long, and run nothing");
  command->add_flag("--quiet", o->quiet, "Errors only");
  command->callback([o, &program, &exit_code] { exit_code = run(program, *o); });
}

}  // namespace terrazzo::cli
