#include "runtime/clients/cli/sweep/sweep_point.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "graph/exception_text.h"
#include "runtime/clients/cli/report.h"
#include "runtime/files.h"
#include "runtime/json_text.h"
#include "runtime/report/provenance.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;

std::shared_ptr<const Graph> load_point(const PointRun& run, const SweepPoint& point) {
  Diagnostics found;
  auto graph =
      std::make_shared<const Graph>(load_graph(run.graph, run.program.registry(), point.overrides, found));
  if (has_errors(found)) throw Error(found.front());
  return graph;
}

json evaluate_point(const PointRun& run, const SweepPoint& point, const std::atomic<bool>* cancel) {
  const auto loaded = run.same_graph ? run.same_graph : load_point(run, point);
  const Graph& graph = *loaded;
  RunOptions options;
  options.targets = target_nodes(graph, point.targets.empty() ? run.targets : point.targets);
  options.output_folder = run.out / point.folder;
  options.threads = run.threads;
  options.memory = run.memory;
  options.cancel = cancel;
  options.provenance = provenance(graph, point.overrides);
  const RunResult result = run.session.evaluator().run(graph, options);
  if (run.history) try {
      run.session.history().record(graph, result, run.session.evaluator().hashes());
    } catch (const std::exception& e) {
      std::cerr << "warning: " << point.folder
                << ": cannot save what `terrazzo explain` needs: " << exception_text(e) << '\n';
    }
  for (const auto& node : result.nodes)
    if (node.saved) std::cerr << point.folder << ": " << node.saved->message.text() << '\n';
  if (result.cancelled()) return nullptr;
  json report = report_json(graph, result, options.threads, point.overrides, options.output_folder);
  report["sweep"] = run.sweep.text();
  return report;
}

void write_point_report(const PointRun& run, const SweepPoint& point, const json& report) {
  write_text_atomically(run.out / point.folder / "report.json", run.keep, json_text(report, 2) + "\n");
}

}  // namespace terrazzo::cli
