// The commands of Slurm that a sweep uses: scontrol, sbatch, squeue, scancel, sinfo.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace terrazzo::cli::slurm {

// The largest number of tasks that one array may have here. Throws Error "no-slurm" if Slurm is not installed
// or its controller does not answer.
std::size_t largest_array();

struct Task {
  std::uint64_t job = 0;              // of the array, for its tasks
  std::optional<std::size_t> number;  // in the array
  std::string name, state, node, reason;
  std::string id() const;  // "12_3"
  // Whether it waits or runs. It is neither while Slurm cleans up after it.
  bool active() const;
  // Whether it was never seen to run.
  bool waits() const { return state.empty() || state == "PENDING"; }
  bool completing() const { return state == "COMPLETING"; }
  // Whether Slurm could not start it and holds it until an administrator acts.
  bool launch_failed() const;
};
// This user's tasks whose job name starts with `prefix`, including those that ended within the last minutes.
// Nothing if the controller does not answer.
std::optional<std::vector<Task>> queue(const std::string& prefix);

// Passes the arguments to sbatch and returns the job's number. Throws Error "sbatch-failed".
std::uint64_t submit(const std::vector<std::string>& arguments);

// Cancels this user's jobs of this name.
void cancel(const std::string& name);
void cancel_task(const std::string& id);

// The names of the nodes in a partition, or of all nodes. Empty if the controller does not answer.
std::vector<std::string> nodes(const std::string& partition);

// The words of "--mem=8G --comment='two words'". Throws Error "usage" if a quote is not closed.
std::vector<std::string> words(const std::string& text);

// "0-3,7" for {0, 1, 2, 3, 7}, which must be sorted.
std::string ranges(const std::vector<std::size_t>& numbers);

}  // namespace terrazzo::cli::slurm
