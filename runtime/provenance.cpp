#include "runtime/provenance.h"

#include <nlohmann/json.hpp>

#include "runtime/json_text.h"

namespace terrazzo {
namespace fs = std::filesystem;

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
  for (const auto& [name, value] : overrides.set) set.push_back(name + "=" + value);
  for (const auto& [name, value] : overrides.parameters) given.push_back(name + "=" + value);
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
