// Predicts which nodes a run would compute, and why, without computing anything.
#pragma once

#include <string>
#include <vector>

#include "runtime/evaluate.h"
#include "runtime/report/history.h"

namespace terrazzo {

struct Plan {
  enum class Step {
    Unneeded,
    Cached,
    Compute,
    Perhaps
  };  // Perhaps: a source runs, but its result may be unchanged
  struct Node {
    Step step = Step::Unneeded;
    std::vector<std::string> reasons;  // one line each
    double seconds = 0;                // computing time of the last run; 0 if unknown
    std::uint64_t bytes = 0;           // size of its outputs in the last run
  };
  std::vector<Node> nodes;  // as in Graph::nodes
};

Plan plan_run(const Graph&, const RunOptions&, Store&, FileHashes&, const History&);

}  // namespace terrazzo
