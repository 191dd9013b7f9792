// Parses the command line, runs one command and returns its exit code: 0 for success, 1 if a node failed, 2
// for wrong usage, 130 if interrupted.
#pragma once

#include <filesystem>

#include "graph/registry.h"
#include "runtime/value.h"

namespace CLI {
class App;
}

namespace terrazzo {

// The node types that a program offers, the value types they exchange, and a reader for provenance.
struct NodeSet {
  Registry registry;
  ValueTypes types;
  // Returns the provenance stored in a file as JSON, or "" if there is none. Null if the program cannot read
  // any file format.
  std::string (*read_provenance)(const std::filesystem::path&) = nullptr;
};

// What run_command_line() needs from the program.
struct Program {
  // Loads the node types on the first call. Their libraries take 0.3 s to load, so a command calls this only
  // when it runs. Help and usage errors do not pay for it.
  const NodeSet& (*nodes)();
  // The same node types without plugins, for running graphs from untrusted files.
  const NodeSet& (*nodes_without_plugins)();
  // Adds the commands that need more than the runtime. Each command stores its exit code. May be null.
  void (*add_commands)(CLI::App&, int& exit_code) = nullptr;

  const Registry& registry() const { return nodes().registry; }
  const ValueTypes& types() const { return nodes().types; }
};

int run_command_line(int argc, char** argv, const Program&);

}  // namespace terrazzo
