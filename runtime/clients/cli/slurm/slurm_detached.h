// What --detach submits: a job of Slurm that runs the same command and does what the command would do while
// it waits. It submits the other jobs, looks after them, and gathers the results of a sweep. After the
// elements of a graph, it submits a second job that runs the rest of the graph with the resources of a task.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/clients/cli/slurm/slurm.h"
#include "runtime/clients/cli/slurm/slurm_options.h"
#include "runtime/hash.h"

namespace terrazzo::cli {

// A queued job that stands for a command.
struct DetachedJob {
  slurm::Task task;
  std::string role;  // job_role::coordinator or finisher
  std::string plan;  // the first digits of its plan's hash
};
// The jobs of this output folder, out of Slurm's queue, that wait, run or ended within the last minutes.
std::vector<DetachedJob> detached_jobs(const std::filesystem::path& out, const std::vector<slurm::Task>&);
// "coordinates" or "runs the rest of the graph"
const char* what_it_does(const DetachedJob&);

// What a command on Slurm computes.
struct DetachablePlan {
  Hash hash;
  std::filesystem::path sweep_file;       // of the sweep, or of the first round
  std::vector<std::string> job_prefixes;  // of the jobs that compute it
};

// To call before the command writes or submits anything. If a job already stands for this command, waits for
// its end; with --detach, returns at once. Returns the exit code if the command is over. Throws Error
// "other-sweep" if a job stands for another command in this folder. In such a job it does not wait. There it
// throws Error "input-changed" or "other-version" if the plan is not the one that was detached.
std::optional<int> wait_for_detached(const DetachablePlan&, const GraphOptions&, const SlurmOptions&);

// Submits the job of this role, and prints its number. Throws Error "no-slurm" or "sbatch-failed".
void submit_detached(const std::string& role, const DetachablePlan&, const GraphOptions&,
                     const SlurmOptions&);

// Runs a command. In a job that stands for it, logs how it ends in jobs/ROLE.jsonl, for `terrazzo status`.
int run_as_job(const GraphOptions&, const SlurmOptions&, const std::function<int()>& command);

// A flag that Slurm sets two minutes before a coordinator's time limit. Then another one takes over.
const std::atomic<bool>* time_is_nearly_over();

}  // namespace terrazzo::cli
