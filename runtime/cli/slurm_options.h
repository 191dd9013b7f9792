// The options of commands that compute on Slurm.
#pragma once

#include <string>
#include <vector>

#include "runtime/cli/options.h"

namespace CLI {
class App;
}

namespace terrazzo::cli {

struct SlurmOptions {
  std::string executor = "local";    // or "slurm"
  std::size_t chunk_size = 0;        // points per task; 0: chosen
  std::size_t parallel = 0;          // tasks at a time; 0: as many as Slurm starts
  std::string partition;             // empty: Slurm's default
  std::vector<std::string> written;  // --slurm
  std::vector<std::string> options;  // its words, for sbatch
  std::string profile;               // file with the first lines of the batch script; may be empty
  bool detach = false;               // return after submission
  double poll = 10;                  // seconds between two looks at the queue
  bool on_slurm() const { return executor == "slurm"; }
};

// `what`: what one task computes, in the plural: "points".
void add_slurm_options(CLI::App&, SlurmOptions&, const std::string& what);

// Fills in `options`. Throws Error "usage" if the options do not fit together.
void complete_slurm_options(SlurmOptions&, const GraphOptions&);

}  // namespace terrazzo::cli
