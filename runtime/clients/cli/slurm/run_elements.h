// Computes the elements of a graph's repeated nodes on Slurm.
#pragma once

#include <filesystem>
#include <optional>

#include "runtime/clients/cli/slurm/slurm_options.h"

namespace terrazzo::cli {

// Runs the rounds of the session's graph, each in a folder of its own below the output folder. Returns
// nothing if all elements are in the cache, so that the session can run the rest. Otherwise prints why, and
// returns the exit code. Throws Error "usage" if no node is repeated, "input-changed" if a file was changed
// meanwhile.
std::optional<int> run_elements(Session&, const GraphOptions&, const SlurmOptions&);

// The folder of a round, from 1, below the output folder of the run.
std::filesystem::path round_folder(const std::filesystem::path& out, std::size_t round);

}  // namespace terrazzo::cli
