// What a run would do, and why: per node cached or not, without computing anything.
#pragma once

#include <string>
#include <vector>

#include "runtime/evaluate.h"
#include "runtime/history.h"

namespace terrazzo {

struct Plan {
  enum class Step {
    Unneeded,
    Cached,
    Compute,
    Perhaps
  };  // Perhaps: a source runs, its result may turn out equal
  struct Node {
    Step step = Step::Unneeded;
    std::vector<std::string> reasons;  // a line each
    double seconds = 0;                // that it took when it was last computed; 0 where unknown
    std::uint64_t bytes = 0;           // of its outputs then
  };
  std::vector<Node> nodes;  // as in Graph::nodes
};

Plan plan_run(const Graph&, const RunOptions&, Store&, FileHashes&, const History&);

}  // namespace terrazzo
