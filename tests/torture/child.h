// Runs the program in child processes, either forked from this one (so that loading the libraries takes 0.3 s
// only once) or started anew.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/clients/cli/command_line.h"
#include "tests/torture/fault_plan.h"

namespace terrazzo::torture {

struct ChildOptions {
  std::filesystem::path program;    // program to start; empty: forks this process
  std::optional<FaultPlan> faults;  // counted by fault_counts()
  std::int64_t largest_file = -1;   // bytes; < 0: no limit
};

struct Ended {
  int exit_code = -1;
  int signal = 0;     // signal that ended the process; 0: none
  bool hung = false;  // killed after a minute
  double seconds = 0;
  std::string out, err;
  std::string text() const;  // how it ended and what it printed
};

class Child {
 public:
  // Runs `terrazzo` with these arguments. Its output goes to files in `folder`.
  Child(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
        const ChildOptions& = {});
  // Runs a function whose result is the exit code.
  Child(const std::function<int()>& work, const std::filesystem::path& folder, const ChildOptions& = {});
  ~Child();
  Child(Child&&) noexcept;
  Child& operator=(Child&&) = delete;

  // `kill_after`: seconds from start to kill −9; < 0: never.
  Ended wait(double kill_after = -1);

 private:
  pid_t pid_ = -1;
  double start_ = 0;
  std::filesystem::path out_, err_;
};

Ended run(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
          const ChildOptions& = {}, double kill_after = -1);

// All node types and value types.
const NodeSet& node_set();

// Fault counts of all children of this process.
FaultCounts& fault_counts();

double now();  // seconds, monotonic

}  // namespace terrazzo::torture
