// Runs the terrazzo program as a user would.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terrazzo::test {

struct ProgramRun {
  int exit_code = -1;
  std::string out, err;
};

struct ProgramOptions {
  double interrupt_after = -1;        // seconds; < 0: never. Ctrl-C
  long largest_file = -1;             // bytes; < 0: no limit. Writing more fails as on a full disk
  std::filesystem::path folder = {};  // to run in
};

ProgramRun run_program(const std::vector<std::string>& arguments, const ProgramOptions& = {});
std::filesystem::path source_folder();

}  // namespace terrazzo::test
