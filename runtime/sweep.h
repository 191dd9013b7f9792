// Sweeps: one graph at many settings. Every point is an immutable set of overrides; how a point gets run is
// an executor's business.
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

// "NODE.PARAM" or a parameter of the graph, and the values it takes.
struct Vary {
  std::string target;
  std::vector<std::string> values;
};
// "pack.seed=1,2,3", "pack.phi=.3:.5:.1" (both ends included where the steps meet them), lists in brackets.
// Throws Error "usage".
Vary parse_vary(const std::string& text);

struct SweepPoint {
  std::size_t index = 0;  // from 1
  std::string folder;     // "point-001", below the sweep's output folder
  std::vector<std::pair<std::string, std::string>> values;
  Overrides overrides;  // the sweep's own and this point's
};
// Every combination; the last one varies fastest.
std::vector<SweepPoint> sweep_points(const std::vector<Vary>&, const Overrides& common);

// Runs points. What comes of a point is the report in its folder (report.json), whoever ran it: so a sweep
// can be gathered from points that ran elsewhere, over a shared cache.
class Executor {
 public:
  virtual ~Executor() = default;
  // Calls `finished` once a point, from any thread, one call at a time; the report is null where the point
  // was cancelled. Returns when all are done.
  virtual void run(const std::vector<SweepPoint>&, const std::atomic<bool>* cancel,
                   const std::function<void(const SweepPoint&, const nlohmann::json& report)>& finished) = 0;
};

// The table over all points, as CSV: what varied, whether it succeeded, seconds, and every metric of every
// node.
std::string sweep_table(const std::vector<SweepPoint>&, const std::vector<nlohmann::json>& reports);

}  // namespace terrazzo
