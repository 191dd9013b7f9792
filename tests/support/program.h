// Runs programs, mostly terrazzo, as a user would.
#pragma once

#include <array>
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
  double kill_after = -1;             // seconds; < 0: never. kill -9
  long largest_file = -1;             // bytes; < 0: no limit. Writing more fails as on a full disk
  long address_space = -1;            // bytes; < 0: no limit
  std::string environment = {};       // one additional NAME=VALUE
  std::filesystem::path folder = {};  // working folder
};

// `command`: the program (searched in PATH if it has no slash) and its arguments.
ProgramRun run_command(const std::vector<std::string>& command, const ProgramOptions& = {});
// Runs terrazzo with these arguments.
ProgramRun run_program(const std::vector<std::string>& arguments, const ProgramOptions& = {});
// Whether this system can create namespaces of process ids.
bool has_pid_namespaces();
// Runs terrazzo twice at the same time, both with the same process id, as on two hosts or in two containers
// that share a disk.
std::array<ProgramRun, 2> run_twice_with_one_process_id(const std::vector<std::string>& arguments);
std::filesystem::path source_folder();
std::filesystem::path build_folder();

}  // namespace terrazzo::test
