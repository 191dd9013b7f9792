// The options of commands that compute on Slurm.
#pragma once

#include <string>
#include <vector>

#include "runtime/clients/cli/options.h"
#include "runtime/sweep/sweep_log.h"

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
  bool detach = false;               // leave everything to jobs
  std::vector<std::string> coordinator_written;  // --slurm-coordinator
  std::vector<std::string> coordinator_options;  // its words
  std::string job_role;                          // empty: this process is no job that stands for a command
  std::string job_plan;                          // hash of what it shall compute
  double poll = 10;                              // seconds between two looks at the queue
  bool on_slurm() const { return executor == "slurm"; }
  bool is_job() const { return !job_role.empty(); }
  bool coordinates() const { return job_role == job_role::coordinator; }
};

// `what`: what one task computes, in the plural: "points".
void add_slurm_options(CLI::App&, SlurmOptions&, const std::string& what);

// Fills in `options`. Throws Error "usage" if the options do not fit together.
void complete_slurm_options(SlurmOptions&, const GraphOptions&);

}  // namespace terrazzo::cli
