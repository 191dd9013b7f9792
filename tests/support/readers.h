// Other people's programs that read exported files. Each is used where it is installed; tests skip otherwise.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace terrazzo::test {

bool has_program(const std::string& name);  // in PATH
std::string chromium();                     // the browser's path, or ""
// Whether Debian's Python has the module.
bool has_python_module(const std::string& name);

// A folder outside the source tree with the files of tests/integration/NAME and npm packages, created once
// and kept for later runs. Empty if node or npm is missing or the packages cannot be installed.
std::filesystem::path npm_check(const std::string& name);
// Runs check.mjs of that folder on a file and returns the JSON that it prints. Adds a failure if it prints
// none.
nlohmann::json run_npm_check(const std::filesystem::path& folder, const std::filesystem::path& file);

// Runs tests/integration/readers/SCRIPT with Debian's Python and returns the JSON that it prints. Adds a
// failure if it prints none.
nlohmann::json run_reader(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace terrazzo::test
