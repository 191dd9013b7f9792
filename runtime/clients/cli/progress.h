// Progress output of a run.
#pragma once

#include <chrono>
#include <map>

#include "runtime/session.h"

namespace terrazzo::cli {

// On a terminal, shows one line that is redrawn at most ten times a second: the number of finished nodes, the
// running nodes, and the estimated time left, based on each node's last run. Elsewhere, prints a line for
// each node that took a second or more, and one every ten seconds for a node that is still running. Failures,
// warnings and files saved by canceled nodes are printed as they occur.
class ProgressLine : public Observer {
 public:
  // `graph`: the evaluated graph, if it is not the session's.
  ProgressLine(Session&, const std::vector<int>& targets, bool quiet, const Graph* graph = nullptr);
  ~ProgressLine() override;
  void started(int node) override;
  void progress(int node, double fraction, const std::string& note) override;
  void finished(int node, const NodeResult&) override;
  // Removes the line. Call it when the run is over.
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  void draw(bool now);
  void clear();
  std::string time_left() const;
  const std::string& path(int node) const { return graph_->nodes[static_cast<std::size_t>(node)].path; }
  std::shared_ptr<const Graph> kept_;
  const Graph* graph_;
  std::vector<bool> waiting_;     // nodes not finished yet
  std::vector<double> expected_;  // seconds; 0: unknown
  std::size_t needed_ = 0, done_ = 0;
  bool line_, quiet_, drawn_ = false;
  struct At {
    double fraction = 0;
    std::string note;
    Clock::time_point start = Clock::now();
    Clock::time_point told = start;
  };
  std::map<int, At> running_;
  Clock::time_point last_{};
};

}  // namespace terrazzo::cli
