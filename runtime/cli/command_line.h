// The command line: parses it, runs one command, returns the exit code (INTERFACE: 0, 1, 2, 130).
#pragma once

#include <filesystem>

#include "graph/registry.h"
#include "runtime/value.h"

namespace CLI {
class App;
}

namespace terrazzo {

// The node types that a program runs, the values that they exchange and the files that they write.
struct NodeSet {
  Registry registry;
  ValueTypes types;
  // Returns the provenance that a written file holds, as JSON; "" if it holds none. Null: no format is known.
  std::string (*read_provenance)(const std::filesystem::path&) = nullptr;
};

// What the program is made of.
struct Program {
  // Loads the node types on the first call. Their libraries take 0.3 s to load, so a command calls this only
  // when it runs: help and usage errors do without.
  const NodeSet& (*nodes)();
  // The same without plugins, to run what a stranger's file asks for.
  const NodeSet& (*nodes_without_plugins)();
  // Adds the commands that need more than the runtime; each stores the exit code. May be null.
  void (*add_commands)(CLI::App&, int& exit_code) = nullptr;

  const Registry& registry() const { return nodes().registry; }
  const ValueTypes& types() const { return nodes().types; }
};

int run_command_line(int argc, char** argv, const Program&);

}  // namespace terrazzo
