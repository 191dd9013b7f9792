// Saves what a canceled node has reached, in a file of its own that replaces no other.
#pragma once

#include <filesystem>

#include "runtime/compute_node.h"
#include "runtime/files/protected_files.h"
#include "runtime/run_result.h"

namespace terrazzo {

// Writes `folder`/NODE.interrupted.EXTENSION, with dots for the slashes of a node inside a subgraph. If that
// exists, the name ends with _2, _3, …, so that an earlier file, which the graph may read, stays. The file
// appears only when it is complete. Never throws: a failure is a warning in the result.
SavedWork save(const InterruptedWork&, const GraphNode&, const std::filesystem::path& folder,
               const ProtectedFiles& = {});

}  // namespace terrazzo
