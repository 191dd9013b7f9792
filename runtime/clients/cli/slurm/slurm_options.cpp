#include "runtime/clients/cli/slurm/slurm_options.h"

#include <CLI/CLI.hpp>

#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/slurm/slurm.h"

namespace terrazzo::cli {

void add_slurm_options(CLI::App& command, SlurmOptions& o, const std::string& what) {
  command.add_option("--executor", o.executor, "Executor that runs the " + what + ": local or slurm")
      ->type_name("EXECUTOR")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  command
      .add_option("--chunk-size", o.chunk_size,
                  "Number of " + what +
                      " per task of Slurm (default: five minutes of work, if the cache knows the times)")
      ->type_name(placeholder::number)
      ->check(CLI::Range(1, 100000));
  command.add_option("--partition", o.partition, "Partition of Slurm")->type_name("NAME");
  command.add_option("--parallel", o.parallel, "Tasks of Slurm that may run at a time")
      ->type_name(placeholder::number)
      ->check(CLI::Range(1, 100000));
  command
      .add_option("--slurm", o.written,
                  "More options for sbatch, such as '--mem=8G --time=2:00:00' (repeatable)")
      ->type_name("OPTIONS")
      ->take_all()
      ->expected(1);
  command
      .add_option("--slurm-profile", o.profile,
                  "File with the first lines of the batch script: #SBATCH options of the site, `module load`")
      ->type_name(placeholder::file)
      ->envname("TERRAZZO_SLURM_PROFILE");
  command.add_flag("--detach", o.detach,
                   "Return after submitting a job that runs this command on a node of the cluster; "
                   "`terrazzo status` shows progress");
  command
      .add_option("--slurm-coordinator", o.coordinator_written,
                  "More options for sbatch, for the job that --detach submits, such as '--partition=serial' "
                  "(repeatable)")
      ->type_name("OPTIONS")
      ->take_all()
      ->expected(1);
  // For the batch script of that job. Not in the help.
  command.add_option("--job-role", o.job_role)
      ->check(CLI::IsMember({job_role::coordinator, job_role::finisher}))
      ->group("");
  command.add_option("--job-plan", o.job_plan)->group("");
  command.add_option("--poll", o.poll, "Seconds between polls of Slurm's queue")
      ->type_name(placeholder::number)
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

void complete_slurm_options(SlurmOptions& s, const GraphOptions& o) {
  if (!s.on_slurm() && (s.chunk_size > 0 || s.parallel > 0 || !s.partition.empty() || s.detach ||
                        !s.written.empty() || !s.coordinator_written.empty()))
    throw Error("usage",
                "--chunk-size, --parallel, --partition, --slurm, --detach and --slurm-coordinator need "
                "--executor slurm");
  if (s.on_slurm() && o.no_cache)
    throw Error("usage", "--executor slurm needs a cache that all machines share: remove --no-cache");
  const auto words = [](const std::vector<std::string>& written) {
    std::vector<std::string> out;
    for (const auto& text : written)
      for (auto& word : slurm::words(text)) out.push_back(std::move(word));
    return out;
  };
  s.options = words(s.written);
  s.coordinator_options = words(s.coordinator_written);
}

}  // namespace terrazzo::cli
