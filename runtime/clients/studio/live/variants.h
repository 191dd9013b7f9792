// One output of a graph for several values of a parameter, side by side. The values are the points of a
// sweep.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "graph/document/edit_document.h"
#include "runtime/clients/studio/live/node_states.h"
#include "runtime/evaluate.h"
#include "runtime/sweep/sweep.h"

namespace terrazzo::studio {

struct VariantsRequest {
  std::string target;      // "NODE.PARAM", or a parameter of the graph
  std::string values;      // as parse_values() reads them
  std::string node, port;  // the output that is shown, by its path in the linked graph
  std::string scope = {};  // of the target: the path of a subgraph's node, or "" for the graph itself
};

// A graph, and the text of it that edits change: its own, or that of a subgraph's file.
struct EditedGraph {
  ReadGraph root, edited;
  std::filesystem::path root_file, file;
  Overrides overrides;

  // The graph with another text in place of the edited one.
  Graph link(const std::string& text, const Registry&, Diagnostics& found) const;
};

// Evaluates the values one after another in its own thread: first all of them up to the first preview of the
// output, then in full. A variant is what edit() makes of the document, so keeping it computes nothing again.
class Variants {
 public:
  // `tell` is called from any thread when json() has changed, and `preview_number` gives unused numbers. All
  // references must outlive this. Throws Error "usage" for values that are no list, "too-large" for too many.
  Variants(Evaluator&, const Registry&, EditedGraph, RunOptions, VariantsRequest,
           std::function<std::uint64_t()> preview_number, std::function<void(const nlohmann::json&)> tell);
  ~Variants();  // cancels and waits

  const std::string& scope() const { return request_.scope; }
  // {target, values, node, port, scope, running, tiles: [{value, state, doing, progress, seconds, output,
  // shapes, preview, error}]}. The states of tiles: "waiting", "running", "preview", "done", "failed",
  // "canceled".
  nlohmann::json json() const;
  void cancel();
  // The edit that makes it the variant. Throws Error "unknown-variant".
  Edit edit(std::size_t tile) const;
  // Whether the graph differs from what they are variants of in the varied value at most.
  bool fit(const EditedGraph&) const;
  // Of a tile's output or preview. Empty if no tile has it.
  std::optional<OutputRecord> record(const std::string& hash) const;
  Value preview(std::uint64_t number) const;

 private:
  struct Tile {
    std::string value, state = "waiting", doing;
    double progress = 0, seconds = 0;
    std::optional<OutputRecord> output, shapes;  // shapes: of particles, to draw them
    std::optional<Preview> preview;
    std::string error;
  };
  struct Watcher;

  void run();
  // `quick`: up to the first preview of the output.
  void evaluate(std::size_t tile, bool quick);
  RunResult evaluate(const Graph&, int node, std::size_t tile, bool quick);
  void stop_nodes();  // with mutex_ held
  template <class Change>
  void change(std::size_t tile, Change&&);
  nlohmann::json locked_json() const;

  Evaluator& evaluator_;
  const Registry& registry_;
  const EditedGraph source_;
  const RunOptions options_;
  const VariantsRequest request_;
  const SweepPoints points_;
  const std::function<std::uint64_t()> preview_number_;
  const std::function<void(const nlohmann::json&)> tell_;
  mutable std::mutex mutex_;
  std::vector<Tile> tiles_;
  std::deque<std::atomic<bool>> stop_;  // of the current evaluation, one per node
  bool canceled_ = false, running_ = true;
  std::thread thread_;
};

}  // namespace terrazzo::studio
