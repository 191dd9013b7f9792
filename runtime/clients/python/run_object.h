// An evaluation that Python code waits for.
#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "runtime/clients/python/graph_object.h"

namespace terrazzo::python {

// Collects events. Worker threads call it without the GIL; the waiting thread draws what it has collected.
class ProgressQueue : public Observer {
 public:
  ProgressQueue(const Graph&, const std::vector<int>& targets);
  void started(int node) override;
  void progress(int node, double fraction, const std::string& note) override;
  void finished(int node, const NodeResult&) override;

  struct Running {
    double fraction = 0;
    std::string note;
  };
  struct State {
    std::size_t done = 0, needed = 0;
    std::map<int, Running> running;
  };
  State state() const;

 private:
  mutable std::mutex mutex_;
  State state_;
};

// What is left of a run when it is not asked for progress any more.
struct FinishedRun {
  std::shared_ptr<const Graph> graph;
  RunResult result;
  std::map<std::string, std::shared_ptr<const GivenValue>> given;
};

// An output of a finished run whose value is read from the store when it is asked for, so that the results of
// many runs need little memory.
struct KeptOutput {
  py::object graph_object;
  std::shared_ptr<const FinishedRun> run;
  Wire wire;
  Value value() const;  // computes it again if the store has dropped it
};

class RunObject {
 public:
  // Starts the evaluation. `apart`: later edits of the graph do not cancel it, and it uses this many threads.
  // Throws Error.
  RunObject(py::object graph, const std::vector<std::string>& targets, const std::filesystem::path& out,
            std::optional<int> apart);
  ~RunObject();  // cancels and waits

  bool done() const { return evaluation_->done(); }
  void cancel() { evaluation_->cancel(); }
  // Waits with the GIL released. Every 50 ms it handles signals, and calls `draw` unless it is None. If a
  // signal handler raises, as for Ctrl-C, it cancels the evaluation, waits for its end and raises.
  void wait(const py::object& draw);

  const Graph& graph() const { return evaluation_->graph(); }
  int threads() const { return threads_; }
  const RunResult& result();  // waits
  void raise_errors();        // those of nodes
  Value value(const std::string& output);
  KeptOutput keep(const std::string& output);
  // The elements of a list, to be asked for one by one, or nothing if the output is one value.
  std::optional<std::vector<std::string>> elements(const std::string& output) const;
  ProgressQueue::State progress() const { return progress_->state(); }

 private:
  Wire evaluated(const std::string& output);  // waits; throws Error "not-evaluated"

  py::object graph_object_;
  GraphObject& owner_;
  std::uint64_t revision_;
  int threads_;
  std::map<std::string, std::shared_ptr<const GivenValue>> given_;
  std::shared_ptr<const Graph> graph_;
  std::shared_ptr<const FinishedRun> kept_;
  py::object cause_ = py::none();  // the first exception of a node in Python
  std::unique_ptr<ProgressQueue> progress_;
  std::shared_ptr<Evaluation> evaluation_;
};

// Call it before anything runs on so many worker threads (0: one per core). Throws Error "shut-down",
// "forked", or "no-memory" if a limit of the address space leaves no room for them.
void require_workers(int threads = 0);

// Cancels every evaluation and waits for all of them, since workers need the interpreter until they end.
void end_all_runs();

// Call it in a forked child. Libraries behind the nodes wait at exit for threads that the child does not have
// (log4cplus, which OpenVDB uses), so the child leaves without their exit handlers.
void leave_without_exit_handlers();

}  // namespace terrazzo::python
