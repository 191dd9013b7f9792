// How a LiveGraph follows its evaluations. Included by live_graph.cpp only.
#pragma once

#include <nlohmann/json.hpp>

#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/json_text.h"

namespace terrazzo::studio {

// Receives the events of one evaluation. Later evaluations may start while it runs: then only what starts
// and how far it is still counts, because its results belong to an earlier graph.
struct LiveGraph::Watcher : Observer {
  LiveGraph& owner;
  std::shared_ptr<const Graph> graph;
  bool current = true;  // with owner.mutex_ held
  bool left = false;    // the document was closed
  bool continues;       // an evaluation of the same graph, which was planned with it

  Watcher(LiveGraph& owner, std::shared_ptr<const Graph> graph, bool continues)
      : owner(owner), graph(std::move(graph)), continues(continues) {}

  const std::string& path(int node) const { return graph->nodes[static_cast<std::size_t>(node)].path; }

  // The node's state, or null if it no longer awaits a result.
  NodeState* pending(int node) {
    if (left) return nullptr;
    const auto it = owner.states_.find(path(node));
    if (it == owner.states_.end()) return nullptr;
    const bool done = it->second.state != "waiting" && it->second.state != "running";
    return done && !current ? nullptr : &it->second;
  }

  void started(int node) override {
    const std::lock_guard lock(owner.mutex_);
    NodeState* s = pending(node);
    if (!s) return;
    s->state = "running";
    s->started = std::chrono::steady_clock::now();
    s->progress = 0;
    s->note.clear();
    owner.tell_node(path(node));
  }

  void progress(int node, double fraction, const std::string& note) override {
    const std::lock_guard lock(owner.mutex_);
    NodeState* s = pending(node);
    if (!s) return;
    s->state = "running";
    s->progress = fraction;
    if (!note.empty()) s->note = note;
    if (owner.large_) return;  // no page shows it
    const auto now = std::chrono::steady_clock::now();
    if (now - s->told < std::chrono::milliseconds(100)) return;
    s->told = now;
    s->told_state = 0;
    owner.events_.add("progress",
                      json_text({{"path", path(node)}, {"progress", s->progress}, {"note", s->note}}));
  }

  bool wants_previews(int node) override {
    const std::lock_guard lock(owner.mutex_);
    return pending(node);
  }

  void preview(int node, const std::string& port, const Value& value) override {
    const std::lock_guard lock(owner.mutex_);
    NodeState* s = pending(node);
    if (!s) return;
    s->previews.insert_or_assign(port, Preview{++owner.previews_, value});
    owner.tell_node(path(node));
  }

  void finished(int node, const NodeResult& r) override {
    const std::lock_guard lock(owner.mutex_);
    if (!current) return;
    NodeState& s = owner.states_[path(node)];
    const bool found = r.status == Status::Memory || r.status == Status::Disk;
    if (continues && found && s.state == "computed") return;
    static const std::map<Status, const char*> words = {
        {Status::Computed, "computed"}, {Status::Memory, "cached"},   {Status::Disk, "cached"},
        {Status::Failed, "failed"},     {Status::Skipped, "skipped"}, {Status::Cancelled, "canceled"}};
    const auto word = words.find(r.status);
    s.state = word == words.end() ? "stale" : word->second;
    s.seconds = r.status == Status::Computed ? r.seconds : r.cached_seconds;
    s.progress = 0;
    s.note.clear();
    s.previews.clear();
    if (r.status == Status::Cancelled || r.status == Status::Skipped)
      s.result.error.reset();  // keeps the outputs of the run before
    else
      s.result = r;
    for (const auto& [port, o] : r.outputs) owner.values_[o.content.text()] = o;
    owner.tell_node(path(node));
  }
};

}  // namespace terrazzo::studio
