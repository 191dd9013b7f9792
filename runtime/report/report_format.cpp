#include "runtime/report/report_format.h"

#include <fmt/format.h>

#include "graph/diagnostic.h"

namespace terrazzo {
using nlohmann::json;

void check_report_format(const json& report, const std::filesystem::path& file) {
  const auto format = report.find("format");
  if (format == report.end()) return;
  if (format->is_number_integer() && *format >= 0 && *format <= kReportFormat) return;
  throw Error("report-format",
              fmt::format("the report '{}' has the format {}, and this program reads up to {}", file.string(),
                          format->dump().substr(0, 40), kReportFormat),
              "use the version of Terrazzo that wrote it, or run again in another folder");
}

}  // namespace terrazzo
