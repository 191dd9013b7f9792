// What pages ask a LiveGraph about its document.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "runtime/clients/studio/live/arrangement.h"
#include "runtime/clients/studio/live/document_json.h"
#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/clients/studio/live/written_files.h"
#include "runtime/files.h"
#include "runtime/files/natural_order.h"
#include "runtime/json_text.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
using nlohmann::json;

EditedGraph LiveGraph::edited_graph(const std::string& scope) {
  const Document& edited = scope.empty() ? document_ : inside(scope);
  return {.root = document_.read(),
          .edited = edited.read(),
          .root_file = document_.file(),
          .file = edited.file(),
          .overrides = overrides_};
}

json LiveGraph::price(const std::vector<Edit>& edits, const std::string& scope) {
  const std::lock_guard lock(mutex_);
  const EditedGraph now = edited_graph(scope);
  std::string text = now.edited.text;
  for (const auto& e : edits) text = edit_document(text, now.file, e);
  Diagnostics found;
  const Graph graph = now.link(text, registry_, found);
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

json LiveGraph::history(const std::string& node, const std::string& port) {
  const std::lock_guard lock(mutex_);
  return past_.list(node, port);
}

json LiveGraph::past(std::size_t number) {
  const std::lock_guard lock(mutex_);
  return json_of(past_.at(number));
}

void LiveGraph::restore(std::size_t number) {
  const std::lock_guard lock(mutex_);
  note_end();
  const PastStates::Texts then = past_.at(number).texts;
  for (const auto& [file, text] : then.inside) {
    Document& document = inside_.at(file);
    if (document.read_only() || document.text() == text) continue;
    document.replace(text);
    save_inside(document);
  }
  document_.replace(then.graph);
  document_changed();
}

PastStates::Texts LiveGraph::texts() const {
  PastStates::Texts out{.graph = document_.text(), .inside = {}};
  for (const auto& [file, document] : inside_) out.inside[file] = document.text();
  return out;
}

bool LiveGraph::varied() try {
  return variants_ && variants_->fit(edited_graph(variants_->scope()));
} catch (const Error&) {
  return false;  // there is no such subgraph now
}

Document& LiveGraph::inside(const std::string& scope) {
  Document* at = &document_;
  for (std::size_t begin = 0; begin <= scope.size();) {
    const std::size_t end = std::min(scope.find('/', begin), scope.size());
    const std::string name = scope.substr(begin, end - begin);
    const auto& nodes = at->read().document.nodes;
    const auto node =
        std::ranges::find_if(nodes, [&](const RawNode& n) { return n.name == name && !n.graph.empty(); });
    if (node == nodes.end()) throw Error("unknown-node", "the graph has no subgraph '" + scope + "'");
    const fs::path file = (at->file().parent_path() / node->graph).lexically_normal();
    // A graph of a stranger must not change files elsewhere.
    const bool locked = document_.read_only() || !is_inside(document_.file().parent_path(), file);
    const auto [opened, first] = inside_.try_emplace(file, file, locked);
    at = &opened->second;
    if (first) past_.add_file(file, at->text());
    if (at->changed_on_disk()) at->reload();
    begin = end + 1;
  }
  return *at;
}

void LiveGraph::require_writable(const Document& document) {
  if (document.read_only())
    throw Error("read-only",
                "'" + document.file().string() + "' is outside the folder of the graph, and is not changed",
                "copy the subgraph into the graph");
}

void LiveGraph::save_inside(Document& document) try { document.save(false); } catch (const Error&) {
  document.undo();
  throw;
}

json LiveGraph::subgraph(const std::string& path) {
  const std::lock_guard lock(mutex_);
  const Document& document = inside(path);
  json out = json_of(document.read().document, registry_);
  if (valid_) add_bypassed(out, *session_.graph(), path + "/");
  add_file(out, document);
  return out;
}

fs::path LiveGraph::file_of(const std::string& scope) {
  const std::lock_guard lock(mutex_);
  return scope.empty() ? document_.file() : inside(scope).file();
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

void LiveGraph::arrange(const json& arrangement, const std::string& group, const std::string& scope) {
  const std::lock_guard lock(mutex_);
  (scope.empty() ? document_ : inside(scope)).arrange(arrangement_text(arrangement), group);
  scope.empty() ? tell_arrangement() : tell_document();
}

}  // namespace terrazzo::studio
