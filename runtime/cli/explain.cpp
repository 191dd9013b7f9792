#include "runtime/explain.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "runtime/cli/commands.h"

namespace terrazzo::cli {

void print_plan(const Program& program, const Graph& graph, const GraphOptions& o, bool reasons) {
  Cache cache(program, o);
  RunOptions options;
  options.targets = target_nodes(graph, o);
  options.output_folder = o.out;
  const Plan plan = plan_run(graph, options, cache.store, cache.hashes, cache.history);
  std::size_t width = 4, compute = 0, perhaps = 0, cached = 0;
  double seconds = 0;
  for (const auto& node : graph.nodes) width = std::max(width, node.path.size());
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const auto& p = plan.nodes[i];
    const char* what = "";
    switch (p.step) {
      case Plan::Step::Unneeded:
        continue;
      case Plan::Step::Cached:
        what = "cached", ++cached;
        break;
      case Plan::Step::Compute:
        what = "runs", ++compute;
        break;
      case Plan::Step::Perhaps:
        what = "may run", ++perhaps;
        break;
    }
    if (p.step != Plan::Step::Cached) seconds += p.seconds;
    std::string line = fmt::format("{:<{}}  {:<8}", graph.nodes[i].path, width, what);
    if (!reasons && p.step != Plan::Step::Cached && p.seconds > 0)
      line += fmt::format("{:.2f} s when last computed", p.seconds);
    if (reasons)
      for (std::size_t k = 0; k < p.reasons.size(); ++k)
        line += (k ? "\n" + std::string(width + 10, ' ') : "") + p.reasons[k];
    std::cout << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }
  std::cout << fmt::format("{} cached, {} to run, {} may run; {:.1f} s known from earlier runs\n", cached,
                           compute, perhaps, seconds);
}

void add_explain(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("explain", "Tell per node whether it would run, and why");
  auto o = std::make_shared<GraphOptions>();
  add_graph_options(*command, *o);
  add_cache_options(*command, *o);
  command->add_option("--target", o->targets, "NODE or NODE.PORT (default: every sink)")
      ->take_all()
      ->expected(1);
  command->callback([o, &program, &exit_code] {
    Graph graph;
    if (!open_graph(program, *o, graph)) {
      exit_code = wrong_usage;
      return;
    }
    print_plan(program, graph, *o, true);
  });
}

}  // namespace terrazzo::cli
