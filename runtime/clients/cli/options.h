// Shared by all commands: options, loading a graph, printing messages.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/clients/cli/command_line.h"
#include "runtime/session.h"

namespace terrazzo::cli {

inline constexpr int kDone = 0;
inline constexpr int kNodeFailed = 1;
inline constexpr int kWrongUsage = 2;
inline constexpr int kInterrupted = 130;

// Options that select a graph and control its evaluation.
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

// "a.b=c" → {"a.b", "c"}. Throws Error "usage" if there is no name before a '=' or the text is not UTF-8.
std::vector<std::pair<std::string, std::string>> split_assignments(const std::vector<std::string>&,
                                                                   const std::string& option);
Overrides overrides(const GraphOptions&);
SessionOptions session_options(const GraphOptions&);
std::filesystem::path default_cache();  // the cache folder without --cache
// The cache folder to use. Empty with --no-cache, and, after a warning, if other users could change the
// default folder. Throws Error "not-a-cache" or "unsafe-folder" for a folder given with --cache.
std::filesystem::path cache_folder(const GraphOptions&);
int threads(const GraphOptions&);

// Prints all messages to standard error.
void print(const Diagnostics&);

// Opens the graph that the options name and prints all messages. False if the graph has errors.
bool open_graph(Session&, const GraphOptions&);

// Call after a command that computed: warns about problems with the cache and keeps it within its limit.
void finish(Session&, const GraphOptions&);

// A flag that Ctrl-C or SIGTERM sets. A second signal ends the process immediately.
const std::atomic<bool>* cancel_on_interrupt();

}  // namespace terrazzo::cli
