#include "runtime/cli/sweep_plan.h"

#include <set>

#include "runtime/action_key.h"
#include "runtime/provenance.h"
#include "runtime/recipe.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

std::string absolute(const fs::path& path) { return fs::absolute(path).lexically_normal().string(); }

// Collects, point by point, which files the sweep reads, and which nodes are the same in every point.
class Planner {
 public:
  Planner(Session& session, SweepFile& file) : session_(session), file_(file) {}

  void add(const Graph& graph) {
    const auto needed = needed_nodes(graph, targets_of(graph));
    add_file(graph.file);
    std::map<std::string, std::string> shared;
    std::vector<bool> is_shared(graph.nodes.size());
    for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
      const GraphNode& node = graph.nodes[i];
      add_file(node.place.file);
      for (const auto& place : node.through) add_file(place.file);
      file_.versions[node.type->name] = node.type->version;
      if (!needed[i]) continue;
      add_inputs(node);
      if (node.type->writes_files) continue;
      bool same = true;
      for (const auto& [port, wires] : node.inputs)
        for (const auto& w : wires) same = same && is_shared[static_cast<std::size_t>(w.node)];
      if (!same) continue;
      std::string own = recipe(graph, node);
      const auto before = shared_.find(node.path);
      if (points_ > 0 && (before == shared_.end() || before->second != own)) continue;
      is_shared[i] = true;
      shared.emplace(node.path, std::move(own));
    }
    shared_ = std::move(shared);
    ++points_;
  }

  // Of any point's graph, after all points were added.
  void finish(const Graph& graph, SweepPlan& plan) const {
    const auto needed = needed_nodes(graph, targets_of(graph));
    std::vector<bool> used(graph.nodes.size());  // by a shared node
    for (std::size_t i = graph.nodes.size(); i-- > 0;) {
      if (!needed[i]) continue;
      const GraphNode& node = graph.nodes[i];
      const bool shared = points_ > 1 && shared_.count(node.path) > 0;
      (shared ? plan.shared_seconds : plan.point_seconds) += known_seconds(graph, node);
      if (!shared) continue;
      if (!used[i]) plan.file.shared.push_back(node.path);
      for (const auto& [port, wires] : node.inputs)
        for (const auto& w : wires) used[static_cast<std::size_t>(w.node)] = true;
    }
  }

 private:
  std::vector<int> targets_of(const Graph& graph) const {
    return file_.targets.empty() ? graph.sinks() : target_nodes(graph, file_.targets);
  }

  void add_file(const std::string& path) {
    if (path.empty() || !seen_.insert(path).second) return;
    if (const auto hash = session_.evaluator().hashes().hash(path))
      file_.files[absolute(path)] = hash->text();
  }

  void add_inputs(const GraphNode& node) {
    std::string key = node.type->name;
    bool any = false;
    for (const auto& p : node.type->parameters)
      if (const auto it = node.parameters.find(p.name);
          p.kind == ParameterKind::InputPath && it != node.parameters.end())
        any = true, key += "\n" + canonical(it->second.value);
    if (!any || !seen_.insert(key).second) return;
    try {
      for (const auto& f : input_files(node, session_.evaluator().hashes()).read)
        file_.files[absolute(f.path)] = f.content.text();
    } catch (const Error&) {
      // The points that read this file report that it is missing.
    }
  }

  double known_seconds(const Graph& graph, const GraphNode& node) const {
    const auto before = session_.history().find(graph, node);
    if (!before) return 0;
    Tier tier;
    const auto record = session_.evaluator().store().find_action(Hash::parse(before->key), tier);
    return record ? record->seconds : 0;
  }

  Session& session_;
  SweepFile& file_;
  std::set<std::string> seen_;
  std::map<std::string, std::string> shared_;  // node → recipe
  std::size_t points_ = 0;
};

}  // namespace

std::optional<SweepPlan> plan_sweep(const Program& program, Session& session, const GraphOptions& o,
                                    SweepPoints points) {
  SweepPlan plan;
  SweepFile& file = plan.file;
  file.folder = fs::current_path().string();
  file.graph = absolute(o.graph);
  file.targets = o.targets;
  file.points = std::move(points);
  file.program = program_version;
  Planner planner(session, file);
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    Diagnostics found;
    const Graph graph = load_graph(o.graph, program.registry(), file.points[i].overrides, found);
    if (has_errors(found)) {
      print(found);
      return {};
    }
    planner.add(graph);
    if (i + 1 == file.points.size()) planner.finish(graph, plan);
  }
  return plan;
}

}  // namespace terrazzo::cli
