#include "runtime/clients/cli/options.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <iostream>

#include "graph/text/utf8.h"
#include "runtime/cache/cache_folder.h"
#include "runtime/cache/disk_cache.h"
#include "runtime/clients/cli/report.h"
#include "runtime/threads/thread_room.h"
#include "runtime/trust.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;

GraphOptions::GraphOptions() : cache_limit(kDefaultCacheLimit) {}

std::vector<std::pair<std::string, std::string>> split_assignments(const std::vector<std::string>& list,
                                                                   const std::string& option) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const auto& text : list) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Error("usage", fmt::format("{} '{}' needs a name and a value", option, text),
                  option == "--set" ? "write --set NODE.PARAM=VALUE" : "write --param NAME=VALUE");
    if (find_invalid_utf8(text) != std::string::npos)
      throw Error("usage", fmt::format("{} '{}' is not UTF-8", option, valid_utf8(text)));
    out.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return out;
}

Overrides overrides(const GraphOptions& o) {
  return {split_assignments(o.set, "--set"), split_assignments(o.parameters, "--param"), {}};
}

SessionOptions session_options(const GraphOptions& o) {
  require_room_for_threads(threads(o));
  return {.cache_folder = cache_folder(o),
          .memory = o.memory > 0 ? o.memory : Store::kDefaultMemory,
          .file_memory = o.memory,
          .output_folder = o.out,
          .threads = threads(o),
          .cancel = cancel_on_interrupt()};
}

int threads(const GraphOptions& o) {
  return o.threads > 0 ? o.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

void print(const Diagnostics& all) {
  for (const auto& d : all) std::cerr << d.text() << '\n';
}

bool open_graph(Session& session, const GraphOptions& o) {
  const Diagnostics found = session.open(o.graph, overrides(o));
  print(found);
  return !has_errors(found);
}

fs::path default_cache() {
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && *xdg) return fs::path(xdg) / "terrazzo";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "terrazzo";
  return fs::temp_directory_path() / fmt::format("terrazzo-cache-{}", ::getuid());
}

namespace {

// Why the default folder is unsafe, or "". If it is in a temporary folder, another user may have created it
// first.
std::string unsafe_default(const fs::path& folder) {
  struct stat s;
  if (::lstat(folder.c_str(), &s) == 0 && S_ISDIR(s.st_mode) && s.st_uid == ::geteuid())
    ::chmod(folder.c_str(), 0700);
  return who_else_may_write(folder);
}

}  // namespace

fs::path cache_folder(const GraphOptions& o) {
  if (o.no_cache) return {};
  if (o.cache.empty()) {
    const fs::path folder = default_cache();
    const std::string why = unsafe_default(folder);
    if (why.empty()) return folder;
    std::cerr << "warning: results are not kept on disk: " << why
              << " (choose a folder that only you can write to with --cache)\n";
    return {};
  }
  try {
    open_cache_folder(o.cache);
  } catch (const Error& e) {
    // An unwritable disk costs time, not results. finish() warns about it at the end of the run.
    if (e.diagnostic().code != "cache-unusable") throw;
  }
  return o.cache;
}

void finish(Session& session, const GraphOptions& o) {
  Store& store = session.evaluator().store();
  store.add_usage();
  if (const std::string trouble = store.trouble(); !trouble.empty())
    std::cerr << "warning: " << trouble << " (results of this run are not kept)\n";
  else if (store.written() > 0)
    tend_cache(store.folder(), o.cache_limit);
}

namespace {
std::atomic<bool> cancel{false};
void on_signal(int) {
  if (cancel.exchange(true)) ::_exit(kInterrupted);
}
}  // namespace

const std::atomic<bool>* cancel_on_interrupt() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  return &cancel;
}

}  // namespace terrazzo::cli
