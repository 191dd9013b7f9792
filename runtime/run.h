// One run of the evaluator. Every node is a task that starts when its sources are done.
#pragma once

#include <tbb/task_group.h>

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "runtime/compute_node.h"
#include "runtime/evaluate.h"
#include "runtime/threads/arena.h"
#include "runtime/threads/thread_marks.h"

namespace terrazzo {

class ProtectedFiles;  // runtime/files/protected_files.h

// The evaluator, the graph and the options must outlive the run.
class Run {
 public:
  Run(Evaluator&, const Graph&, const RunOptions&);

  RunResult run();

  // Implements Evaluator::value().
  static Value fetch(Evaluator&, const Graph&, const RunResult&, const Wire&, const RunOptions&);

 private:
  using Inputs = std::map<std::string, std::vector<OutputRecord>>;
  enum class Outcome { Done, Elsewhere, FilesChanged };
  struct State {
    std::atomic<int> waiting{0};
    std::atomic<int> users{0};  // consumers that may still need a value
    std::vector<int> consumers;
    std::map<std::string, Value> values;  // kept while `users` > 0
    std::mutex mutex;                     // protects `values` and recomputation
    double seconds_again = 0;             // time spent recomputing a lost value
    InputFiles files;
  };

  int threads() const;
  NodeResult& result(int i) { return result_.nodes[i]; }
  State& state(int i) { return states_[i]; }
  const GraphNode& node(int i) const { return graph_.nodes[i]; }
  bool cancelled(int i) const;
  // Whether the whole run is canceled, not only nodes that an edit made obsolete.
  bool run_is_cancelled() const;
  Work work(int i, const Work::Report*) const;
  // If the observer throws, it receives no more events, but the run continues.
  template <class Call>
  void tell(Call&& call) {
    if (!options_.observer) return;
    const std::lock_guard lock(observer_mutex_);
    if (!result_.trouble.empty()) return;
    try {
      call(*options_.observer);
    } catch (const std::exception& e) {
      result_.trouble = std::string("the progress display stopped: ") + e.what();
    }
  }

  // run.cpp: the order of the nodes
  void visit(int i);
  void fail(int i, const Error&);
  // The contents of the inputs, without what is left out. None if the node cannot run.
  std::optional<Inputs> inputs_of(int i);
  // Returns false if the key is being computed elsewhere.
  bool evaluate(int i);

  // run_node.cpp: one node
  // Computes the node, unless another task or run is computing the same key.
  Outcome compute_alone(int i, const Inputs&);
  bool use_cached(int i);
  // Whether an input file changed since its key was computed.
  bool files_changed(int i);
  // Returns false, without storing anything, if an input file changed meanwhile.
  bool compute(int i, const Inputs&);
  // Keeps a value that cannot be read back from the disk as long as consumers may need it. Other values are
  // left to the store and its memory budget.
  void keep(int i, const std::string& port, Value);
  ComputeRequest request(int i, Work);
  void write_requests(int i, ComputeRequest&);
  // The files that no node may overwrite, listed once.
  std::shared_ptr<const ProtectedFiles> protected_files();
  // Notes that a node writes a file. Throws Error "same-file" if another node of this run has written it, by
  // whatever path. Equal names in the graph were refused when it was loaded.
  void claim(int i, const std::filesystem::path& file, const std::string& shown);

  // run_values.cpp: the values of nodes
  // `keep`: whether a value that is read from the disk stays in memory.
  Value value_of(const Wire&, bool keep = true);
  void compute_again(int i);

  Evaluator& e_;
  const Graph& graph_;
  const RunOptions& options_;
  std::vector<State> states_;
  RunResult result_;
  tbb::task_group group_;
  std::optional<Arena> arena_;
  ThreadMark mark_;
  std::mutex observer_mutex_;
  std::once_flag protected_once_;
  std::shared_ptr<const ProtectedFiles> protected_;
  std::mutex writers_mutex_;
  std::map<std::string, int> writers_;  // node by place of the file
};

}  // namespace terrazzo
