// What every command shares: the options, the graph they name, the messages.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/cli/command_line.h"
#include "runtime/session.h"

namespace terrazzo::cli {

inline constexpr int done = 0, node_failed = 1, wrong_usage = 2, interrupted = 130;

// Options that name a graph and how it is evaluated.
struct GraphOptions {
  std::string graph;
  std::vector<std::string> set, parameters, targets;  // "NODE.PARAM=VALUE", "NAME=VALUE", "NODE[.PORT]"
  std::string out = "out";
  std::string cache;  // "": the user's default folder
  std::uint64_t cache_limit;
  std::uint64_t memory = 0;  // 0: not given
  bool no_cache = false;
  bool quiet = false;
  int threads = 0;
  GraphOptions();
};

// "a.b=c" → {"a.b", "c"}. Throws Error "usage" where there is no '='.
std::vector<std::pair<std::string, std::string>> split_assignments(const std::vector<std::string>&,
                                                                   const std::string& option);
Overrides overrides(const GraphOptions&);
SessionOptions session_options(const GraphOptions&);
std::filesystem::path default_cache();  // where results are kept if nobody says where
// The cache folder to use, or none with --no-cache and, with a warning, where the default folder could be
// changed by other users. Throws Error "not-a-cache" or "unsafe-folder" for a folder given with --cache.
std::filesystem::path cache_folder(const GraphOptions&);
int threads(const GraphOptions&);

// Prints all messages to standard error.
void print(const Diagnostics&);

// Opens the graph that the options name. Prints what it finds; false where it cannot be run.
bool open_graph(Session&, const GraphOptions&);

// After a command that computed: tells trouble with the cache, and keeps the cache within its limit.
void finish(Session&, const GraphOptions&);

// Set by Ctrl-C; the second one ends the process at once.
const std::atomic<bool>* cancel_on_interrupt();

}  // namespace terrazzo::cli
