// The format of report.json, which runs write, and which sweeps, `terrazzo status` and `terrazzo reproduce`
// read.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace terrazzo {

// "format" in a report. It grows when readers of the present format would misunderstand a report. Reports
// without it are of version 0.2, and can be read.
inline constexpr int kReportFormat = 1;

// Throws Error "report-format" if a newer version of the program wrote the report.
void check_report_format(const nlohmann::json& report, const std::filesystem::path& file);

}  // namespace terrazzo
