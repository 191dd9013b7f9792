// Submits the jobs of a sweep to Slurm.
#pragma once

#include <string>
#include <vector>

#include "runtime/clients/cli/slurm/slurm.h"
#include "runtime/clients/cli/slurm/slurm_options.h"
#include "runtime/clients/cli/sweep/sweep_plan.h"

namespace terrazzo::cli {

// The jobs of a sweep are named "PREFIXshared", and "PREFIXN" for an array that runs it in N chunks. So a
// sweep finds its jobs again without a file of job numbers. `out`: the sweep's output folder.
std::string slurm_job_prefix(const Hash& sweep, const std::filesystem::path& out);

// A word for bash, in quotes.
std::string quoted_word(const std::string& text);
// The first lines of each batch script. Throws Error "usage" if the profile cannot be read.
std::string profile_text(const SlurmOptions&);
// Arguments of sbatch for every job. `log`: the file in `folder` for what it prints.
std::vector<std::string> sbatch_arguments(const std::string& name, const std::filesystem::path& folder,
                                          const std::string& log, const GraphOptions&, const SlurmOptions&);

class SlurmJobs {
 public:
  // Throws Error "usage" if a path is not UTF-8 or the profile cannot be read.
  // `folder`: the working folder. `out`: the sweep's folder.
  SlurmJobs(const Hash& sweep, const std::string& folder, const std::filesystem::path& out,
            const GraphOptions&, const SlurmOptions&);
  const std::string& prefix() const { return prefix_; }
  std::string shared_name() const;
  std::string chunks_name(std::size_t chunks) const;

  // The number of points per task. Throws Error "no-slurm".
  std::size_t chunk_size(std::size_t points, double point_seconds) const;
  // Both return the job's number, and throw Error "sbatch-failed". `exclude`: nodes not to use.
  std::uint64_t submit_shared(const std::vector<std::string>& exclude) const;
  // `need_shared`: the workers stop if the cache lacks what all points share. `after`: the shared job, or 0.
  std::uint64_t submit_chunks(const std::vector<std::size_t>& numbers, std::size_t chunks, bool need_shared,
                              std::uint64_t after, const std::vector<std::string>& exclude) const;

 private:
  std::filesystem::path script(const std::string& name, const std::string& part) const;
  std::vector<std::string> arguments(const std::string& name, const std::string& log,
                                     const std::vector<std::string>& exclude) const;
  const Hash sweep_;
  const GraphOptions& options_;
  const SlurmOptions& slurm_;
  const std::filesystem::path out_;
  const std::string prefix_;
  std::string profile_;
};

}  // namespace terrazzo::cli
