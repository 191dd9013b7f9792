// Runs a sweep, or the parts of a graph, on Slurm: what all points share as one job, then an array of chunks
// of points.
#pragma once

#include <memory>

#include "runtime/clients/cli/slurm/slurm_jobs.h"

namespace terrazzo::cli {

class SlurmExecutor : public Executor {
 public:
  // After run(): this process is a job whose time is nearly over, and points may still be running.
  virtual bool out_of_time() const = 0;
  virtual bool gave_up() const = 0;  // after run(): messages on standard error say why
};
// Prints messages to standard error. `store`: the cache that all machines share. `out`: the sweep's folder.
// All arguments must outlive the executor. Throws Error "usage".
std::unique_ptr<SlurmExecutor> slurm_executor(const SweepPlan&, Store& store,
                                              const std::filesystem::path& out, const GraphOptions&,
                                              const SlurmOptions&);

}  // namespace terrazzo::cli
