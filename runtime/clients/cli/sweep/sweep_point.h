// Evaluates single points of a sweep; shared by `sweep` and `sweep-worker`.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "runtime/clients/cli/options.h"
#include "runtime/files/protected_files.h"
#include "runtime/sweep/sweep.h"

namespace terrazzo::cli {

struct PointRun {
  const Program& program;
  Session& session;
  std::filesystem::path graph;
  std::vector<std::string> targets;
  std::filesystem::path out;  // the sweep's output folder
  int threads;
  std::uint64_t memory;
  Hash sweep;                                    // SweepFile::hash(), written into the report
  const ProtectedFiles& keep;                    // what the sweep reads
  bool history;                                  // whether to record what `terrazzo explain` needs
  std::shared_ptr<const Graph> same_graph = {};  // of all points, if they are parts of one graph
};
// The graph of a point. Throws the first Error of the graph.
std::shared_ptr<const Graph> load_point(const PointRun&, const SweepPoint&);
// Evaluates a point and prints warnings. Returns its report, or null if it was canceled. Does not write it.
nlohmann::json evaluate_point(const PointRun&, const SweepPoint&, const std::atomic<bool>* cancel);
void write_point_report(const PointRun&, const SweepPoint&, const nlohmann::json& report);

}  // namespace terrazzo::cli
