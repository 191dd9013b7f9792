#include "runtime/clients/cli/slurm/slurm_job.h"

#include <fmt/format.h>

namespace terrazzo::cli {
namespace fs = std::filesystem;

std::string SlurmJob::ending(const fs::path& logs) const {
  std::string out = fmt::format("{}: task {}{} ended ({})", label, task.id(),
                                task.node.empty() ? "" : " on " + task.node, task.state);
  if (!trouble.empty()) out += ": " + trouble;
  if (task.state == "TIMEOUT") out += "; raise the limit with --slurm '--time=…' or use smaller chunks";
  if (task.state == "OUT_OF_MEMORY") out += "; raise the limit with --slurm '--mem=…'";
  return out + fmt::format("; log: {}", (logs / (name + ".txt")).string());
}

}  // namespace terrazzo::cli
