// The state of a LiveGraph as pages get it.
#include <nlohmann/json.hpp>

#include "runtime/json_text.h"
#include "runtime/studio/arrangement.h"
#include "runtime/studio/document_json.h"
#include "runtime/studio/live_graph.h"

namespace terrazzo::studio {
using nlohmann::json;

json LiveGraph::document_json() const {
  Diagnostics ignored;
  json out = json_of(read_document(document_.text(), document_.file(), ignored), registry_);
  if (valid_) add_bypassed(out, *session_.graph(), "");
  json messages = json::array();
  for (const auto& d : found_) messages.push_back(json_of(d));
  out["file"] = document_.file().string();
  out["text"] = document_.text();
  out["saved"] = document_.saved(), out["read_only"] = document_.read_only();
  out["can_undo"] = document_.can_undo(), out["can_redo"] = document_.can_redo();
  out["recovered"] = document_.recovered();
  out["trouble"] = document_.trouble();
  out["disk_changed"] = disk_changed_;
  out["valid"] = valid_;
  out["messages"] = messages;
  out["arrangement"] = read_arrangement(document_.file());
  return out;
}

json LiveGraph::state() {
  const std::lock_guard lock(mutex_);
  json nodes = json::object();
  for (const auto& [path, s] : states_) nodes[path] = json_of(s);
  return {{"number", events_.last()}, {"document", document_json()}, {"nodes", nodes}, {"run", run_json()}};
}

void LiveGraph::tell_node(const std::string& path) {
  json j = json_of(states_[path]);
  j["path"] = path;
  events_.add("node", json_text(j));
}

}  // namespace terrazzo::studio
