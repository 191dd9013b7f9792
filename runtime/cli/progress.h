// The progress line of a run on a terminal.
#pragma once

#include <chrono>
#include <map>

#include "runtime/evaluate.h"

namespace terrazzo::cli {

// Draws on standard error, at most ten times a second, and only where that is a terminal. Failures and
// warnings are printed as they come, terminal or not.
class ProgressLine : public Observer {
 public:
  ProgressLine(const Graph&, std::size_t needed, bool quiet);
  ~ProgressLine() override;
  void started(int node) override;
  void progress(int node, double fraction, const std::string& note) override;
  void finished(int node, const NodeResult&) override;

 private:
  void draw(bool now);
  void clear();
  const Graph& graph_;
  std::size_t needed_, done_ = 0;
  bool line_, quiet_, drawn_ = false;
  struct At {
    double fraction = 0;
    std::string note;
  };
  std::map<int, At> running_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace terrazzo::cli
