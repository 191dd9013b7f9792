// What pages ask a LiveGraph about its document.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "runtime/clients/studio/live/arrangement.h"
#include "runtime/clients/studio/live/document_json.h"
#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/clients/studio/live/written_files.h"
#include "runtime/files/natural_order.h"
#include "runtime/json_text.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
using nlohmann::json;

json LiveGraph::price(const std::vector<Edit>& edits) {
  const std::lock_guard lock(mutex_);
  std::string text = document_.text();
  for (const auto& e : edits) text = edit_document(text, document_.file(), e);
  Diagnostics found;
  const Graph graph = load_graph_text(text, document_.file(), registry_, overrides_, found);
  if (has_errors(found)) throw Error(found.front());
  RunOptions options;
  options.targets = target_nodes(graph, safe_targets(graph));
  options.output_folder = session_.options().output_folder;
  auto& e = session_.evaluator();
  const Plan plan = plan_run(graph, options, e.store(), e.hashes(), session_.history());
  json nodes = json::array();
  double seconds = 0;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const Plan::Node& p = plan.nodes[i];
    if (p.step != Plan::Step::Compute && p.step != Plan::Step::Perhaps) continue;
    nodes.push_back({{"path", graph.nodes[i].path},
                     {"seconds", p.seconds},
                     {"reason", p.reasons.empty() ? "" : p.reasons.front()},
                     {"perhaps", p.step == Plan::Step::Perhaps}});
    seconds += p.seconds;
  }
  return {{"nodes", nodes}, {"seconds", seconds}};
}

json LiveGraph::history() {
  const std::lock_guard lock(mutex_);
  return past_.list();
}

json LiveGraph::past(std::size_t number) {
  const std::lock_guard lock(mutex_);
  return json_of(past_.at(number));
}

void LiveGraph::restore(std::size_t number) {
  change([&](Document& d) { d.replace(past_.at(number).text); });
}

json LiveGraph::subgraph(const std::string& path) {
  const std::lock_guard lock(mutex_);
  Diagnostics found;
  std::string shown;
  RawDocument doc = read_document(document_.text(), document_.file(), found);
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    const std::string name = path.substr(at, end - at);
    const auto node =
        std::ranges::find_if(doc.nodes, [&](const RawNode& n) { return n.name == name && !n.graph.empty(); });
    if (node == doc.nodes.end()) throw Error("unknown-node", "the graph has no subgraph '" + path + "'");
    const fs::path file = (doc.file.parent_path() / node->graph).lexically_normal();
    const auto text = read_graph_text(file, found);
    if (!text) throw Error(found.back());
    doc = read_document(shown = *text, file, found);
    at = end + 1;
  }
  json out = json_of(doc, registry_);
  if (valid_) add_bypassed(out, *session_.graph(), path + "/");
  out["file"] = doc.file.string();
  out["text"] = shown;
  return out;
}

json LiveGraph::files() {
  constexpr std::size_t kMost = 2000;
  constexpr int kDeep = 4;
  fs::path folder;
  {
    const std::lock_guard lock(mutex_);
    folder = document_.file().parent_path();
  }
  std::vector<std::string> list;
  std::size_t seen = 0;
  bool more = false;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end;
       !error && it != end; it.increment(error)) {
    if ((more = ++seen > 20 * kMost || list.size() >= kMost)) break;
    const std::string name = it->path().filename().string();
    std::error_code ignored;
    if (it->is_directory(ignored) && (name.starts_with('.') || it.depth() >= kDeep))
      it.disable_recursion_pending();
    if (it->is_regular_file(ignored) && !name.starts_with('.'))
      list.push_back(it->path().lexically_relative(folder).string());
  }
  std::ranges::sort(list, natural_less);
  return {{"files", list}, {"more", more}};
}

BundleRequest LiveGraph::bundle_request() {
  const std::lock_guard lock(mutex_);
  return {.graph = document_.file(), .text = document_.text()};
}

json LiveGraph::outputs() {
  const std::lock_guard lock(mutex_);
  const fs::path folder = fs::absolute(session_.options().output_folder).lexically_normal();
  return {{"folder", folder.string()}, {"files", written_files(*session_.graph(), states_, folder)}};
}

fs::path LiveGraph::output(const std::string& path) {
  const std::lock_guard lock(mutex_);
  return written_file(*session_.graph(), states_, session_.options().output_folder, path);
}

void LiveGraph::arrange(const json& arrangement, const std::string& group) {
  const std::lock_guard lock(mutex_);
  document_.arrange(arrangement_text(arrangement), group);
  tell_arrangement();
}

}  // namespace terrazzo::studio
