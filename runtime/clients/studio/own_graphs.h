// Graph files of the user, below the folder in which the Studio was started.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/clients/studio/workspace.h"

namespace terrazzo::studio {

struct OwnGraph {
  std::string file;  // relative to the folder
  double changed;    // seconds since 1970
};

// The graph files that changed last, newest first: at most 60, and at most four folders deep. Looks at 20,000
// files at most, and not into hidden folders.
std::vector<OwnGraph> own_graphs(const Workspace&);

}  // namespace terrazzo::studio
