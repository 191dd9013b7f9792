// The state of a sweep, from its folder: sweep.json, the workers' logs and the points' reports.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runtime/sweep/sweep_file.h"

namespace terrazzo {

struct PointStatus {
  enum class State : std::uint8_t { Waiting, Running, Done, Failed } state = State::Waiting;
  int log = -1;  // index in SweepStatus::logs of the worker that last wrote about it; −1: none
};

// The log of one chunk, of what all points share, or of a job that stands for the command.
struct LogStatus {
  std::filesystem::path text;  // what the workers printed; it exists only for jobs of Slurm
  std::string name;            // "chunk-3-of-40"
  std::string host, task;      // of the last event
  std::size_t point = 0;       // the point that was started last, from 1; 0: none
  std::int64_t since = 0;      // seconds since 1970, when it started
  std::string trouble;         // why the last worker stopped; empty if it did not
  bool finished = false;       // a job that is not a chunk has done its work
};

struct SweepFailure {
  std::size_t point = 0;  // from 1; 0: a whole worker stopped
  int log = -1;
  std::string message;
};

struct SweepStatus {
  SweepFile sweep;
  std::vector<PointStatus> points;
  std::vector<LogStatus> logs;
  std::vector<SweepFailure> failures;
  std::vector<std::pair<std::filesystem::path, std::size_t>> damaged;  // logs, with lines that were left out
  double seconds = 0;                               // spent on finished points, by all workers
  std::size_t timed = 0;                            // number of these points
  std::size_t computed = 0, cached = 0, twice = 0;  // nodes
  std::size_t count(PointStatus::State) const;
};

// `folder`: the sweep's folder. `out`: the output folder of the command, where its jobs write their logs; for
// the elements of a graph it is another one. Throws Error "sweep-file".
SweepStatus sweep_status(const std::filesystem::path& folder, const std::filesystem::path& out);

// What a worker printed while it ran this point (from 0) last. Throws Error "no-log" if there is none.
std::string point_log(const SweepStatus&, std::size_t point);

}  // namespace terrazzo
