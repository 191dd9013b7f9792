#include "runtime/clients/cli/sweep/sweep_plan.h"

#include <set>

#include "runtime/cache/action_key.h"
#include "runtime/report/provenance.h"
#include "runtime/report/recipe.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

std::string absolute(const fs::path& path) { return fs::absolute(path).lexically_normal().string(); }

// Collects, point by point, which files the sweep reads, and which nodes are the same in every point.
class Planner {
 public:
  Planner(Session& session, SweepFile& file) : session_(session), file_(file) {}

  // The files and node types of a graph.
  void add_sources(const Graph& graph) {
    const auto needed = needed_nodes(graph, targets_of(graph));
    add_file(graph.file);
    for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
      const GraphNode& node = graph.nodes[i];
      add_file(node.place.file);
      for (const auto& place : node.through) add_file(place.file);
      file_.versions[node.type->name] = node.type->version;
      if (needed[i]) add_inputs(node);
    }
  }

  void add(const Graph& graph) {
    add_sources(graph);
    const auto needed = needed_nodes(graph, targets_of(graph));
    std::map<std::string, std::string> shared;
    std::vector<bool> is_shared(graph.nodes.size());
    for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
      const GraphNode& node = graph.nodes[i];
      if (!needed[i] || node.type->writes_files) continue;
      bool same = true;
      for (const auto& [port, wires] : node.inputs)
        for (const auto& w : wires) same = same && is_shared[w.node];
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
    std::vector<const GraphNode*> all_shared, others;
    for (std::size_t i = graph.nodes.size(); i-- > 0;) {
      if (!needed[i]) continue;
      const GraphNode& node = graph.nodes[i];
      const bool shared = points_ > 1 && shared_.count(node.path) > 0;
      (shared ? all_shared : others).push_back(&node);
      if (!shared) continue;
      if (!used[i]) plan.file.shared.push_back(node.path);
      for (const auto& [port, wires] : node.inputs)
        for (const auto& w : wires) used[w.node] = true;
    }
    plan.shared_seconds = known_seconds(graph, all_shared);
    plan.point_seconds = known_seconds(graph, others);
  }

  // The computing time of these nodes in their last runs with this cache; 0 if one of them is unknown.
  double known_seconds(const Graph& graph, const std::vector<const GraphNode*>& nodes) const {
    double sum = 0;
    for (const GraphNode* node : nodes) {
      const auto before = session_.history().find(graph, *node);
      Tier tier;
      const auto record =
          before ? session_.evaluator().store().find_action(Hash::parse(before->key), tier) : nullptr;
      if (!record) return 0;
      sum += record->seconds;
    }
    return sum;
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
          p.kind == ParameterKind::InputPath && it != node.parameters.end()) {
        any = true;
        key += "\n" + canonical(it->second.value);
      }
    if (!any || !seen_.insert(key).second) return;
    try {
      for (const auto& f : input_files(node, session_.evaluator().hashes()).read)
        file_.files[absolute(f.path)] = f.content.text();
    } catch (const Error&) {
      // The points that read this file report that it is missing.
    }
  }

  Session& session_;
  SweepFile& file_;
  std::set<std::string> seen_;
  std::map<std::string, std::string> shared_;  // node → recipe
  std::size_t points_ = 0;
};

SweepFile sweep_file(const GraphOptions& o) {
  SweepFile out;
  out.folder = fs::current_path().string();
  out.graph = absolute(o.graph);
  out.targets = o.targets;
  out.program = program_version;
  return out;
}

// These nodes and all that they need.
std::vector<const GraphNode*> upstream(const Graph& graph, const std::vector<std::string>& nodes) {
  const auto needed = needed_nodes(graph, target_nodes(graph, nodes));
  std::vector<const GraphNode*> out;
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (needed[i]) out.push_back(&graph.nodes[i]);
  return out;
}

}  // namespace

std::optional<SweepPlan> plan_sweep(const Program& program, Session& session, const GraphOptions& o,
                                    SweepPoints points) {
  SweepPlan plan;
  SweepFile& file = plan.file;
  file = sweep_file(o);
  file.points = std::move(points);
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

std::vector<SweepPlan> plan_rounds(Session& session, const GraphOptions& o) {
  const Graph& graph = *session.graph();
  SweepFile all = sweep_file(o);
  Planner planner(session, all);
  planner.add_sources(graph);
  std::vector<SweepPlan> out;
  for (auto& round :
       graph_rounds(graph, o.targets.empty() ? graph.sinks() : target_nodes(graph, o.targets))) {
    SweepPlan plan{all, 0, 0};
    std::vector<std::string> targets;
    for (const auto& part : round.parts)
      targets.insert(targets.end(), part.targets.begin(), part.targets.end());
    plan.shared_seconds = planner.known_seconds(graph, upstream(graph, round.shared));
    plan.point_seconds = planner.known_seconds(graph, upstream(graph, targets)) / round.parts.size();
    plan.file.shared = std::move(round.shared);
    plan.file.points = SweepPoints::of_parts(std::move(round.parts), overrides(o));
    out.push_back(std::move(plan));
  }
  return out;
}

}  // namespace terrazzo::cli
