#include "runtime/cache/action_key.h"

#include <algorithm>

#include "graph/input_file.h"
#include "runtime/files.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace fs = std::filesystem;

Hash record_key(const NodeType& type, const Hash& key, const std::filesystem::path& output_folder) {
  if (!type.writes_files) return key;
  return hash_of(key.text() + std::filesystem::absolute(output_folder).lexically_normal().string());
}

std::vector<fs::path> files_opened(const NodeType& type, const fs::path& path) {
  std::vector<fs::path> files{path};
  if (type.companion_files)
    for (auto& companion : type.companion_files(path))
      if (companion != path) files.push_back(std::move(companion));
  return files;
}

std::optional<Hash> input_content(const NodeType& type, const std::filesystem::path& path, FileHashes& hashes,
                                  std::uint64_t most) {
  const auto hash = hashes.hash(path, most);
  if (!hash) return {};
  std::string text = hash->text() + path.extension().string();
  if (type.companion_files)
    for (const auto& companion : type.companion_files(path)) {
      const auto other = hashes.hash(companion, most);
      text += "\n" + companion.filename().string() + "=" + (other ? other->text() : "none");
    }
  return hash_of(text);
}

namespace {

Error unreadable(const fs::path& path) {
  const InputFile file(path);
  return Error("unreadable-file",
               "cannot read '" + path.string() + "'" +
                   (file ? ": it kept changing while it was read" : ": " + file.trouble()));
}

}  // namespace

InputFiles input_files(const GraphNode& node, FileHashes& hashes, std::uint64_t memory) {
  InputFiles out;
  std::uint64_t most = 0;
  for (const auto& p : node.type->parameters) {
    const auto written = node.parameters.find(p.name);
    if (p.kind != ParameterKind::InputPath || written == node.parameters.end()) continue;
    if (most == 0) most = memory > 0 ? std::min(memory, available_memory()) : available_memory();
    const std::string& pattern = std::get<std::string>(written->second.value);
    auto& paths = out.paths[p.name] = expand_glob(pattern);
    if (paths.empty())
      throw Error("no-file", "there is no file '" + pattern + "'",
                  "paths in a graph are relative to the graph file")
          .parameter(p.name);
    try {
      for (const auto& path : paths) {
        const auto content = input_content(*node.type, path, hashes, most);
        if (!content) throw unreadable(path);
        out.hashes[p.name].push_back(*content);
        for (const auto& f : files_opened(*node.type, path))
          if (const auto hash = hashes.hash(f, most)) out.read.push_back({f.string(), *hash});
      }
    } catch (Error& e) {
      throw e.parameter(p.name);
    }
  }
  return out;
}

Hash action_key(const GraphNode& node, const std::map<std::string, std::vector<Hash>>& files,
                const std::map<std::string, std::vector<OutputRecord>>& inputs) {
  HashWriter w;
  w.text(node.type->name);
  w.pod(node.type->version);
  for (const auto& p : node.type->parameters) {
    w.text(p.name);
    if (const auto f = files.find(p.name); f != files.end()) {
      for (const auto& h : f->second) w.text(h.text());
      continue;
    }
    const auto it = node.parameters.find(p.name);
    w.text(it != node.parameters.end() ? canonical(it->second.value) : p.value ? canonical(*p.value) : "");
  }
  for (const auto& port : node.type->inputs) {
    w.text(port.name);
    const auto it = inputs.find(port.name);
    w.pod<std::uint64_t>(it == inputs.end() ? 0 : it->second.size());
    if (it != inputs.end())
      for (const auto& r : it->second) w.text(r.content.text());
  }
  return w.hash();
}

}  // namespace terrazzo
