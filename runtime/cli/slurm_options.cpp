#include "runtime/cli/slurm_options.h"

#include <CLI/CLI.hpp>

#include "runtime/cli/placeholders.h"
#include "runtime/cli/slurm.h"

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
                   "Return after submitting to Slurm; `terrazzo status` shows progress, and the same command "
                   "without --detach gathers the results");
  command.add_option("--poll", o.poll, "Seconds between two looks at Slurm's queue")
      ->type_name(placeholder::number)
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

void complete_slurm_options(SlurmOptions& s, const GraphOptions& o) {
  if (!s.on_slurm() &&
      (s.chunk_size > 0 || s.parallel > 0 || !s.partition.empty() || s.detach || !s.written.empty()))
    throw Error("usage", "--chunk-size, --parallel, --partition, --slurm and --detach need --executor slurm");
  if (s.on_slurm() && o.no_cache)
    throw Error("usage", "--executor slurm needs a cache that all machines share: remove --no-cache");
  s.options.clear();
  for (const auto& text : s.written)
    for (auto& word : slurm::words(text)) s.options.push_back(std::move(word));
}

}  // namespace terrazzo::cli
