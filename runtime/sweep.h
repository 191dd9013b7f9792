// Sweeps: one graph at many settings. A sweep point is an immutable set of overrides. An executor runs the
// points.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "graph/graph.h"

namespace terrazzo {

// "NODE.PARAM" or a graph parameter, and its values in the sweep.
struct Vary {
  std::string target;
  std::vector<std::string> values;
};
// Parses "pack.seed=1,2,3" or "pack.phi=0.3:0.5:0.1" (LO:HI:STEP, both ends included if the steps reach
// them). A list value is written in brackets. Throws Error "usage".
Vary parse_vary(const std::string& text);

struct SweepPoint {
  std::size_t index = 0;  // from 1
  std::string folder;     // "point-001", below the sweep's output folder
  std::vector<std::pair<std::string, std::string>> values;
  Overrides overrides;  // those common to all points, and this point's values
};
// All combinations of values; the last parameter varies fastest. Throws Error "usage".
std::vector<SweepPoint> sweep_points(const std::vector<Vary>&, const Overrides& common);

// Runs sweep points. Each point's result is the report.json in its folder, whichever executor ran it. So the
// results of points that ran on other machines with a shared cache can be gathered too.
class Executor {
 public:
  virtual ~Executor() = default;
  // Calls `finished` once per point, from any thread, one call at a time. The report is null if the point was
  // cancelled. Returns when all points are done.
  virtual void run(const std::vector<SweepPoint>&, const std::atomic<bool>* cancel,
                   const std::function<void(const SweepPoint&, const nlohmann::json& report)>& finished) = 0;
};

// A CSV table with one row per point: the varied values, the status, the time in seconds, and every metric of
// every node.
std::string sweep_table(const std::vector<SweepPoint>&, const std::vector<nlohmann::json>& reports);

}  // namespace terrazzo
