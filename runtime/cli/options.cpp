#include "runtime/cli/options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <iostream>

#include "runtime/disk_cache.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;

GraphOptions::GraphOptions() : cache_limit(default_cache_limit) {}

std::vector<std::pair<std::string, std::string>> split_assignments(const std::vector<std::string>& list,
                                                                   const std::string& option) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const auto& text : list) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Error("usage", fmt::format("{} '{}' has no value", option, text),
                  option == "--set" ? "write --set NODE.PARAM=VALUE" : "write --param NAME=VALUE");
    out.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return out;
}

Overrides overrides(const GraphOptions& o) {
  return {split_assignments(o.set, "--set"), split_assignments(o.parameters, "--param"), {}};
}

SessionOptions session_options(const GraphOptions& o) {
  return {.cache_folder = cache_folder(o),
          .memory = o.memory > 0 ? o.memory : Store::default_memory,
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

fs::path cache_folder(const GraphOptions& o) {
  if (o.no_cache) return {};
  if (!o.cache.empty()) return o.cache;
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && *xdg) return fs::path(xdg) / "terrazzo";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "terrazzo";
  return fs::temp_directory_path() / fmt::format("terrazzo-cache-{}", ::getuid());
}

void finish(Session& session, const GraphOptions& o) {
  Store& store = session.evaluator().store();
  if (const std::string trouble = store.trouble(); !trouble.empty())
    std::cerr << "warning: " << trouble << " (results of this run are not kept)\n";
  else if (store.written() > 0)
    collect_cache(store.folder(), o.cache_limit);
}

namespace {
std::atomic<bool> cancel{false};
void on_signal(int) {
  if (cancel.exchange(true)) ::_exit(interrupted);
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
