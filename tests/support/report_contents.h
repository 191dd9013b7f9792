// The results in the report of a run.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace terrazzo::test {

// The content hash of every output, by NODE.PORT; empty if there is no report.
std::map<std::string, std::string> report_contents(const std::filesystem::path& report);

}  // namespace terrazzo::test
