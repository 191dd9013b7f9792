// The command line: parses it, runs one command, returns the exit code (INTERFACE: 0, 1, 2, 130).
#pragma once

#include <filesystem>

#include "graph/registry.h"
#include "runtime/value.h"

namespace CLI {
class App;
}

namespace terrazzo {

// What the program is made of.
struct Program {
  const Registry& registry;
  const ValueTypes& types;
  // The provenance that a written file holds, as JSON; "" where it holds none. Null: no format is known.
  std::string (*read_provenance)(const std::filesystem::path&) = nullptr;
  // Adds the commands that need more than the runtime; each stores the exit code. May be null.
  void (*add_commands)(CLI::App&, int& exit_code) = nullptr;
};

int run_command_line(int argc, char** argv, const Program&);

}  // namespace terrazzo
