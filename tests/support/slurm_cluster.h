// A Slurm cluster on this machine: a controller and three nodes, without systemd, in a temporary folder.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace terrazzo::test {

class SlurmCluster {
 public:
  // Starts all daemons. If that fails, trouble() gives the reason.
  explicit SlurmCluster(const std::filesystem::path& folder);
  ~SlurmCluster();  // ends all jobs and daemons
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;
  const std::string& trouble() const { return trouble_; }

  std::string environment() const;  // SLURM_CONF=…, for Slurm's commands
  ProgramRun command(const std::vector<std::string>& words) const;
  // The lines of squeue in this format, of waiting and running tasks.
  std::vector<std::string> queue(const std::string& format = "%i %T") const;

  void start_controller();
  void kill_controller();
  void start_node(const std::string& name);  // "n1", "n2", "n3"
  // Kills the node's slurmd, slurmstepd and tasks, as if the machine lost power.
  void kill_node(const std::string& name);
  // Starts what waits to be started again after its node died, for which Slurm takes two minutes.
  void start_again() const;
  // The processes of the tasks that run on a node, or on all nodes.
  std::vector<pid_t> tasks(const std::string& node = "") const;

 private:
  pid_t start(const std::string& name, const std::vector<std::string>& words);
  void kill(const std::string& name);
  std::filesystem::path folder_;
  std::string trouble_;
  std::map<std::string, pid_t> daemons_;
};

// Waits until `happened` is true, for at most this many seconds. False if it never was.
bool wait_until(double seconds, const std::function<bool()>& happened);

}  // namespace terrazzo::test
