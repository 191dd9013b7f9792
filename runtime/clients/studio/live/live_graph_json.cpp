// The state of a LiveGraph as pages get it.
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "runtime/clients/studio/live/arrangement.h"
#include "runtime/clients/studio/live/document_json.h"
#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/json_text.h"

namespace terrazzo::studio {
using nlohmann::json;
namespace {

constexpr std::size_t kMostMessages = 1000;

bool has_messages(const NodeState& s) { return s.result.error || !s.result.warnings.empty(); }

}  // namespace

json LiveGraph::document_json() {
  const RawDocument& read = document_.read().document;
  json out = json_of(read, registry_, !large_);
  if (valid_ && !large_) add_bypassed(out, *session_.graph(), "");
  out["node_count"] = read.nodes.size();
  json messages = json::array();  // errors first, so that none is beyond the limit because of warnings
  for (const bool errors : {true, false})
    for (const auto& d : found_)
      if ((d.severity == Severity::Error) == errors && messages.size() < kMostMessages)
        messages.push_back(json_of(d));
  if (found_.size() > kMostMessages)
    messages.push_back(json_of(Diagnostic{Severity::Note,
                                          "more",
                                          std::to_string(found_.size() - kMostMessages) + " more messages",
                                          "",
                                          {},
                                          "",
                                          ""}));
  add_file(out, document_);
  out["recovered"] = document_.recovered();
  out["trouble"] = document_.trouble();
  out["disk_changed"] = disk_changed_;
  out["valid"] = valid_;
  out["varied"] = varied();
  out["messages"] = messages;
  return out;
}

json LiveGraph::state() {
  const std::lock_guard lock(mutex_);
  json nodes = json::object();
  for (const auto& [path, s] : states_)
    if (!large_ || has_messages(s)) nodes[path] = json_of(s);
  return {{"number", events_.last()},
          {"document", document_json()},
          {"nodes", nodes},
          {"run", run_json()},
          {"variants", variants_ ? variants_->json() : json()}};
}

void LiveGraph::tell_document() {
  disk_changed_ = disk_changed_ && !document_.saved();
  events_.add("document", json_text(document_json()));
}

void LiveGraph::tell_arrangement() {
  events_.add("arrangement", json_text({{"arrangement", arrangement_json(document_.arrangement())},
                                        {"can_undo", document_.can_undo()},
                                        {"can_redo", document_.can_redo()},
                                        {"trouble", document_.trouble()}}));
}

void LiveGraph::tell_node(const std::string& path) {
  NodeState& s = states_[path];
  if (large_ && s.told_state == 0 && !has_messages(s)) return;
  json j = json_of(s);
  j["path"] = path;
  std::string text = json_text(j);
  // An edit plans all nodes and changes few of them.
  if (const std::size_t now = std::hash<std::string>()(text); std::exchange(s.told_state, now) != now)
    events_.add("node", std::move(text));
}

}  // namespace terrazzo::studio
