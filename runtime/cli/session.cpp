#include "runtime/cli/session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>

namespace terrazzo::cli {
namespace fs = std::filesystem;

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

void print(const Diagnostics& all) {
  for (const auto& d : all) std::cerr << d.text() << '\n';
}

bool open_graph(const Program& program, const GraphOptions& o, Graph& graph) {
  Diagnostics found;
  Overrides overrides{split_assignments(o.set, "--set"), split_assignments(o.parameters, "--param")};
  graph = load_graph(o.graph, program.registry, overrides, found);
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

std::string provenance(const Graph& graph, const GraphOptions& o, const Registry& registry) {
  nlohmann::json versions = nlohmann::json::object();
  for (const auto& node : graph.nodes) versions[node.type->name] = registry.find(node.type->name)->version;
  nlohmann::json parameters = nlohmann::json::object();
  for (const auto& node : graph.nodes)
    for (const auto& [name, p] : node.parameters)
      if (node.type->find_parameter(name)->kind != ParameterKind::InputPath)
        parameters[node.path][name] = written(p.value);
      else
        parameters[node.path][name] = fs::path(written(p.value)).filename().string();
  return nlohmann::json{{"program", "terrazzo"},   {"graph", fs::path(graph.file).filename().string()},
                        {"name", graph.name},      {"set", o.set},
                        {"param", o.parameters},   {"node_versions", versions},
                        {"parameters", parameters}}
      .dump();
}

Cache::Cache(const Program& program, const GraphOptions& o)
    : folder(cache_folder(o)),
      store(program.types, folder),
      hashes(folder.empty() ? fs::path() : folder / "files"),
      history(folder.empty() ? fs::path() : folder / "history") {}

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
