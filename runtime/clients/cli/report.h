// Reports of a run: the table of nodes, the metrics and the JSON report.
#pragma once

#include <iosfwd>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "runtime/evaluate.h"

namespace terrazzo::cli {

// `folder`: the folder of the report. Paths in the report's graph ("document") are relative to it.
nlohmann::json report_json(const Graph&, const RunResult&, int threads, const Overrides&,
                           const std::filesystem::path& folder);
void print_table(std::ostream&, const Graph&, const RunResult&);
void print_metrics(std::ostream&, const Graph&, const RunResult&);
// The first and the last file of every node that reads several, in the order in which it reads them.
void print_stacks(std::ostream&, const Graph&, const RunResult&);
// A value's JSON as text: tables in columns, other types as "name: value" lines with long lists shortened.
std::string readable(const std::string& type, const nlohmann::json&);
std::string bytes_text(std::uint64_t);

}  // namespace terrazzo::cli
