// The log of a worker: one line of JSON per event, appended to one file per chunk. So a coordinator learns
// what happened from a few files instead of looking into every point's folder. The log is a hint: a point is
// finished if its report says so.
//
// Every line has "event", "host", "task" (of Slurm, or the process) and "time" (seconds since 1970). Events:
//   started      point; without it, a job that stands for a command
//   finished     point, status, seconds, computed, cached, twice, twice_seconds, errors
//   warning      message
//   stopped      message: this worker cannot go on; another machine may
//   missing      this worker stopped because the cache lacks what all points share
//   refused      message: no worker can run this sweep as it was planned
//   interrupted  by a signal: Ctrl-C, scancel, or the time limit
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace terrazzo {

// Below the sweep's output folder: "jobs/chunk-3-of-40.jsonl", and ".txt" for what the worker prints.
std::filesystem::path jobs_folder(const std::filesystem::path& out);
std::string chunk_name(std::size_t chunk, std::size_t chunks);
inline constexpr const char* shared_name = "shared";
// The report of the nodes that all points share: "jobs/shared.json".
std::filesystem::path shared_report(const std::filesystem::path& out);

// The jobs that --detach submits (runtime/clients/cli/slurm/slurm_detached.h), and the names of their logs.
namespace job_role {
inline constexpr const char *coordinator = "coordinator", *finisher = "finisher";
}

class WorkerLog {
 public:
  explicit WorkerLog(std::filesystem::path file) : file_(std::move(file)) {}
  // Appends a line with one write. False if that failed.
  bool write(nlohmann::json event) const;

 private:
  std::filesystem::path file_;
};

class LogReader {
 public:
  // Skips what is there now if `skip`.
  LogReader(std::filesystem::path file, bool skip);
  // The complete lines that were added since the last call. Leaves out damaged lines: the entries of the
  // others have the types that WorkerLog gives them.
  std::vector<nlohmann::json> news();
  std::size_t damaged() const { return damaged_; }  // lines that were left out so far

 private:
  std::filesystem::path file_;
  std::size_t offset_ = 0, damaged_ = 0;
};

}  // namespace terrazzo
