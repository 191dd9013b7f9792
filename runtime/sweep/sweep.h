// Sweeps: one graph at many settings. A sweep point is an immutable set of overrides. An executor runs the
// points. The parts of one graph can be the points of a sweep too.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/report/graph_parts.h"

namespace terrazzo {

// "NODE.PARAM" or a graph parameter, and its values in the sweep.
struct Vary {
  std::string target;
  std::vector<std::string> values;
};
// The values of "1,2,3" or "0.3:0.5:0.1" (LO:HI:STEP, both ends included if the steps reach them). A list
// value is written in brackets. Throws Error "usage".
std::vector<std::string> parse_values(const std::string& text);
// Parses "pack.seed=1,2,3" or "pack.phi=0.3:0.5:0.1". Throws Error "usage".
Vary parse_vary(const std::string& text);

struct SweepPoint {
  std::size_t index = 0;                                    // from 1
  std::string folder;                                       // "point-001", below the sweep's output folder
  std::vector<std::pair<std::string, std::string>> values;  // for a part: "element" and its name
  Overrides overrides;               // those common to all points, and this point's values
  std::vector<std::string> targets;  // of a part of the graph; otherwise empty
  std::string name() const;          // the folder, or the name of the part
  std::string caption() const;       // "point-001: pack.seed 1, pack.phi 0.3"
};

// All combinations of values, where the last parameter varies fastest; or the parts of a graph. Points are
// made when they are asked for, so a sweep of many points takes no memory.
class SweepPoints {
 public:
  SweepPoints() = default;
  // Throws Error "usage" if a target is varied twice or there are more than 100,000 points.
  SweepPoints(std::vector<Vary>, Overrides common);
  static SweepPoints of_parts(std::vector<GraphPart>, Overrides common);
  std::size_t size() const { return size_; }
  SweepPoint operator[](std::size_t i) const;  // from 0
  // The index, from 0, of the point with this folder, number or name: "point-012", "12" or "block[11]".
  std::optional<std::size_t> find(const std::string& name) const;
  const std::vector<Vary>& vary() const { return vary_; }
  const std::vector<GraphPart>& parts() const { return parts_; }  // empty if values are varied
  const Overrides& common() const { return common_; }

 private:
  std::vector<Vary> vary_;
  std::vector<GraphPart> parts_;
  Overrides common_;
  std::size_t size_ = 0, width_ = 3;
};

// The points of one chunk, from 0: `first` to `last` − 1. Every point is in one of the `chunks` chunks.
struct PointRange {
  std::size_t first, last;
};
PointRange points_of(std::size_t chunk, std::size_t chunks, std::size_t points);

// Runs sweep points. Each point's result is the report.json in its folder, whichever executor ran it. So the
// results of points that ran on other machines with a shared cache can be gathered too.
class Executor {
 public:
  virtual ~Executor() = default;
  // Calls `finished` once per point that ran, from any thread, one call at a time. The report is null if the
  // point was canceled. Returns when all points are done or the executor gives up on the others.
  virtual void run(const SweepPoints&, const std::atomic<bool>* cancel,
                   const std::function<void(const SweepPoint&, const nlohmann::json& report)>& finished) = 0;
};

// What a sweep keeps of a point's report.
struct PointSummary {
  std::string status = "done";  // or "failed" or "cancelled"
  double seconds = 0;
  std::size_t computed = 0, cached = 0;  // nodes
  std::vector<std::string> errors;       // "NODE: message"
  bool cannot_write = false;             // a node failed because it could not write a file
};
PointSummary summary_of(const nlohmann::json& report);

// The report in a file. Null if the file cannot be read or is no report of a run: others may have damaged it,
// and it may be of an earlier version. What this returns has every entry that summary_of(), SweepTable and
// the functions of runtime/sweep/sweep_file.h read. Throws Error
// "report-format" if a newer version of the program wrote it.
nlohmann::json read_report(const std::filesystem::path&);

// Collects a CSV table with one row per point: the varied values, the status, the time in seconds, and every
// metric of every node. Keeps 16 bytes per metric of a point, not the reports.
class SweepTable {
 public:
  explicit SweepTable(const SweepPoints&);
  void add(std::size_t point, const nlohmann::json& report);  // `point` from 0
  // Passes the table to `write`, row by row.
  void write(const std::function<void(const std::string&)>& write) const;

 private:
  struct Row {
    std::string status;  // empty: not run
    double seconds = 0;
    std::vector<std::pair<std::size_t, double>> metrics;  // column, value
  };
  const SweepPoints& points_;
  std::vector<Row> rows_;
  std::map<std::pair<std::string, std::string>, std::size_t> columns_;  // of a node's metric
};

}  // namespace terrazzo
