// One job of a sweep on Slurm, as its coordinator knows it.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "runtime/clients/cli/slurm/slurm.h"
#include "runtime/sweep/sweep.h"
#include "runtime/sweep/sweep_log.h"

namespace terrazzo::cli {

// A task of the array, or the job for what all points share.
struct SlurmJob {
  std::string label;  // "chunk 3 of 40"
  std::string name;   // of its files
  LogReader log;
  PointRange points = {};
  std::size_t missing = 0, missing_before = 0;  // points without a result; when it was submitted
  bool submitted = false, active = false, gave_up = false;
  bool misses_shared = false;  // it stopped because the cache has lost what all points share
  int times_without_shared = 0;
  int attempts = 0;
  std::optional<std::chrono::steady_clock::time_point> gone_since = {};
  slurm::Task task = {};     // as last seen
  std::string trouble = {};  // the worker's last message

  // Why it ended without its results, for the user. `logs`: the folder of its files.
  std::string ending(const std::filesystem::path& logs) const;
};

}  // namespace terrazzo::cli
