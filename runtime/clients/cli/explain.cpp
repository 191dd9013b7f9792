#include "runtime/report/explain.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/report.h"

namespace terrazzo::cli {

void print_plan(Session& session, const GraphOptions& o, bool reasons) {
  const Graph& graph = *session.graph();
  RunOptions options;
  options.targets = target_nodes(graph, o.targets);
  options.output_folder = o.out;
  const Plan plan =
      plan_run(graph, options, session.evaluator().store(), session.evaluator().hashes(), session.history());
  std::size_t width = 4, compute = 0, perhaps = 0, cached = 0;
  std::size_t unknown = 0;
  std::uint64_t bytes = 0;
  double seconds = 0;
  for (const auto& node : graph.nodes) width = std::max(width, node.path.size());
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const auto& p = plan.nodes[i];
    const char* what = "";
    switch (p.step) {
      case Plan::Step::Unneeded:
        continue;
      case Plan::Step::Cached:
        what = "cached";
        ++cached;
        break;
      case Plan::Step::Compute:
        what = "runs";
        ++compute;
        break;
      case Plan::Step::Perhaps:
        what = "may run";
        ++perhaps;
        break;
    }
    if (p.step != Plan::Step::Cached) {
      seconds += p.seconds;
      bytes += p.bytes;
      unknown += p.seconds == 0;
    }
    std::string line = fmt::format("{:<{}}  {:<8}", graph.nodes[i].path, width, what);
    if (!reasons && p.step != Plan::Step::Cached && p.seconds > 0)
      line += fmt::format("{:.2f} s and {} when last computed", p.seconds, bytes_text(p.bytes));
    if (reasons)
      for (std::size_t k = 0; k < p.reasons.size(); ++k)
        line += (k ? "\n" + std::string(width + 10, ' ') : "") + p.reasons[k];
    std::cout << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }
  std::cout << fmt::format("{} cached, {} to run, {} may run", cached, compute, perhaps);
  if (compute + perhaps > 0)
    std::cout << fmt::format(": about {:.1f} s and {}, based on earlier runs{}", seconds, bytes_text(bytes),
                             unknown ? fmt::format(" ({} without an earlier run)", unknown) : "");
  std::cout << '\n';
}

void add_explain(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("explain", "Show for each node whether it would run, and why");
  auto o = std::make_shared<GraphOptions>();
  add_graph_options(*command, *o);
  add_run_options(*command, *o);
  add_target_option(*command, *o, "explain");
  command->callback([o, &program, &exit_code] {
    const NodeSet& nodes = program.nodes();  // loaded first: session_options checks the address space left
    Session session(nodes.registry, nodes.types, session_options(*o));
    if (open_graph(session, *o))
      print_plan(session, *o, true);
    else
      exit_code = kWrongUsage;
  });
}

}  // namespace terrazzo::cli
