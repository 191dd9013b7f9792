#include "runtime/files/protected_files.h"

#include <fmt/format.h>

#include <set>

#include "runtime/cache/action_key.h"
#include "runtime/files.h"

namespace terrazzo {
namespace fs = std::filesystem;

ProtectedFiles::ProtectedFiles(const Graph& graph) {
  std::set<std::string> documents{graph.file}, patterns;
  for (const GraphNode& node : graph.nodes) {
    documents.insert(node.place.file);
    for (const Place& place : node.through) documents.insert(place.file);
    for (const Parameter& p : node.type->parameters) {
      const auto it = node.parameters.find(p.name);
      if (p.kind != ParameterKind::InputPath || it == node.parameters.end()) continue;
      const auto& pattern = std::get<std::string>(it->second.value);
      if (!patterns.insert(node.type->name + "\n" + pattern).second) continue;
      for (const auto& path : expand_glob(pattern))
        for (const auto& file : files_opened(*node.type, path)) add(file);
    }
  }
  for (const auto& file : documents)
    if (!file.empty()) add(file, "which belongs to the graph");
}

void ProtectedFiles::add(const fs::path& path, const std::string& why) {
  files_.add(path);
  why_.emplace(path, why);
}

void ProtectedFiles::require_other(const fs::path& path, const std::string& shown) const {
  const fs::path* file = replaced_by(path);
  if (!file) return;
  throw Error("overwrites-input",
              fmt::format("'{}' would overwrite '{}', {}", shown.empty() ? path.string() : shown,
                          file->string(), why_.at(*file)),
              "choose another file name, or another folder with --out");
}

}  // namespace terrazzo
