#include "runtime/report/file_provenance.h"

#include <nlohmann/json.hpp>

#include "graph/document/write_graph.h"
#include "runtime/files/json_input.h"
#include "runtime/given.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace fs = std::filesystem;

std::string file_provenance(const Graph& graph, int node, const RunResult& result,
                            const RunOptions& options) {
  nlohmann::json all = options.provenance.empty() ? nlohmann::json::object() : parse_json(options.provenance);
  const auto upstream = used_nodes(graph, result, node);
  all["files"] = nlohmann::json::array();
  for (std::size_t k = 0; k < upstream.size(); ++k) {
    if (!upstream[k]) continue;
    all["keys"][graph.nodes[k].path] = result.nodes[k].key.text();
    for (const auto& f : result.nodes[k].read)
      all["files"].push_back({{"node", graph.nodes[k].path},
                              {"name", fs::path(f.path).filename().string()},
                              {"content", f.content.text()}});
  }
  if (auto values = given_values_json(graph, upstream); !values.empty()) all["values"] = std::move(values);
  all["document"] = write_graph_without_folders(graph, upstream);
  return json_text(all);
}

}  // namespace terrazzo
