// What every command shares: the node types, the graph named on the command line, the cache, the messages.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/evaluate.h"
#include "runtime/history.h"

namespace terrazzo::cli {

inline constexpr int done = 0, node_failed = 1, wrong_usage = 2, interrupted = 130;

struct Program {
  const Registry& registry;
  const ValueTypes& types;
};

// Options that name a graph and how it is evaluated.
struct GraphOptions {
  std::string graph;
  std::vector<std::string> set, parameters, targets;  // "NODE.PARAM=VALUE", "NAME=VALUE", "NODE[.PORT]"
  std::string out = "out";
  std::string cache;  // "": the user's default folder
  bool no_cache = false;
  bool quiet = false;
  int threads = 0;
};

// "a.b=c" → {"a.b", "c"}. Throws Error "usage" where there is no '='.
std::vector<std::pair<std::string, std::string>> split_assignments(const std::vector<std::string>&,
                                                                   const std::string& option);

// Prints all messages to standard error.
void print(const Diagnostics&);

// Loads and checks the graph. Prints what it finds; false where it cannot be run.
bool open_graph(const Program&, const GraphOptions&, Graph&);

std::filesystem::path cache_folder(const GraphOptions&);  // empty with --no-cache

// The graph, its overrides and the program's version, as JSON.
std::string provenance(const Graph&, const GraphOptions&, const Registry&);

// Store, file hashes and history over one cache folder.
struct Cache {
  Cache(const Program&, const GraphOptions&);
  std::filesystem::path folder;
  Store store;
  FileHashes hashes;
  History history;
};

// Set by Ctrl-C; the second one ends the process at once.
const std::atomic<bool>* cancel_on_interrupt();

}  // namespace terrazzo::cli
