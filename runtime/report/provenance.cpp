#include "runtime/report/provenance.h"

#include <nlohmann/json.hpp>
#include <set>

#include "graph/document/raw_document.h"
#include "graph/document/yaml_text.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

// Overrides as "NAME=VALUE". Of a value that is an input path or begins one, only the name of the file
// remains.
class Assignments {
 public:
  explicit Assignments(const Graph& graph) : bases_{fs::current_path(), fs::path(graph.file).parent_path()} {
    for (const auto& node : graph.nodes)
      for (const auto& [name, p] : node.parameters)
        if (node.type->find_parameter(name)->kind == ParameterKind::InputPath)
          paths_.insert(fs::absolute(written(p.value)).lexically_normal().string());
  }
  std::string text(const std::pair<std::string, std::string>& set) const {
    if (set.second.find('/') == std::string::npos) return set.first + "=" + set.second;
    WrittenValue value = read_written(set.second);
    for (std::string& item : value.items) item = without_folders(item);
    return set.first + "=" + (value.is_list ? yaml_list(value.items) : value.text());
  }

 private:
  std::string without_folders(const std::string& item) const {
    for (const fs::path& base : bases_) {
      const std::string from = fs::absolute(base / item).lexically_normal().string();
      for (const std::string& path : paths_)
        if (!item.empty() && path.starts_with(from)) {
          const bool folder = path.size() > from.size() && (path[from.size()] == '/' || from.ends_with('/'));
          return folder ? "" : fs::path(item).filename().string();
        }
    }
    return item;
  }
  std::vector<fs::path> bases_;
  std::set<std::string> paths_;  // absolute
};

}  // namespace

std::string provenance(const Graph& graph, const Overrides& overrides) {
  nlohmann::json versions = nlohmann::json::object(), parameters = nlohmann::json::object(),
                 set = nlohmann::json::array(), given = nlohmann::json::array();
  for (const auto& node : graph.nodes) {
    versions[node.type->name] = node.type->version;
    for (const auto& [name, p] : node.parameters) {
      const bool path = node.type->find_parameter(name)->kind == ParameterKind::InputPath;
      parameters[node.path][name] = path ? fs::path(written(p.value)).filename().string() : written(p.value);
    }
  }
  const Assignments assignments(graph);
  for (const auto& value : overrides.set) set.push_back(assignments.text(value));
  for (const auto& value : overrides.parameters) given.push_back(assignments.text(value));
  return json_text({{"program", "terrazzo"},
                    {"version", program_version},
                    {"graph", fs::path(graph.file).filename().string()},
                    {"name", graph.name},
                    {"set", set},
                    {"param", given},
                    {"node_versions", versions},
                    {"parameters", parameters}});
}

}  // namespace terrazzo
