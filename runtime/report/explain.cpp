#include "runtime/report/explain.h"

#include <fmt/format.h>

#include <set>
#include <string_view>

#include "graph/text/read_number.h"

namespace terrazzo {
namespace {

using Step = Plan::Step;

std::string at(const GraphNode& node, const std::string& parameter) {
  const auto it = node.parameters.find(parameter);
  return it == node.parameters.end() ? "its default" : it->second.place.text();
}

// A value of a parameter as people write it: a color as "#c7bda8", a list of one as its element.
std::string shown(const Parameter& p, const std::string& written) {
  const bool list = written.size() > 2 && written.front() == '[' && written.back() == ']';
  if (list && p.kind == ParameterKind::Color)
    if (const auto rgb = read_numbers(std::string_view(written).substr(1, written.size() - 2));
        rgb && rgb->size() == 3)
      return color_text({rgb->at(0), rgb->at(1), rgb->at(2)});
  const bool one = list && written.find(',') == std::string::npos;
  return one ? written.substr(1, written.size() - 2) : written;
}

void compare(const GraphNode& node, const HistoryEntry& before, const HistoryEntry& now,
             std::vector<std::string>& reasons) {
  if (before.type != now.type)
    reasons.push_back(fmt::format("the node's type changed: {} → {}", before.type, now.type));
  else if (before.version != now.version)
    reasons.push_back(fmt::format("{} has a new version: {} → {}", now.type, before.version, now.version));
  for (const auto& p : node.type->parameters) {
    const auto old = before.parameters.find(p.name), fresh = now.parameters.find(p.name);
    const bool differs =
        old != before.parameters.end() && fresh != now.parameters.end() && old->second != fresh->second;
    const auto old_files = before.files.find(p.name), fresh_files = now.files.find(p.name);
    const bool read_before = old_files != before.files.end(), reads = fresh_files != now.files.end();
    // Equal content in another place is no reason. A keyword, such as a built-in model, names no file.
    if ((read_before && reads) ? old_files->second != fresh_files->second
                               : read_before != reads && !differs) {
      reasons.push_back(fmt::format("the content of {} changed: '{}' ({})", p.name,
                                    fresh == now.parameters.end() ? "" : fresh->second, at(node, p.name)));
    } else if (differs && !(read_before && reads)) {
      reasons.push_back(fmt::format("parameter {} changed: {} → {} ({})", p.name, shown(p, old->second),
                                    shown(p, fresh->second), at(node, p.name)));
    } else if ((old == before.parameters.end()) != (fresh == now.parameters.end())) {
      reasons.push_back(fmt::format("parameter {} was added or removed", p.name));
    }
  }
  std::set<std::string> ports;
  for (const auto& [port, content] : before.inputs) ports.insert(port);
  for (const auto& [port, content] : now.inputs) ports.insert(port);
  for (const auto& port : ports) {
    const auto old = before.inputs.find(port), fresh = now.inputs.find(port);
    if (old == before.inputs.end())
      reasons.push_back(fmt::format("input {} is now connected", port));
    else if (fresh == now.inputs.end())
      reasons.push_back(fmt::format("input {} is no longer connected", port));
    else if (old->second != fresh->second)
      reasons.push_back(fmt::format("the content of input {} changed", port));
  }
}

std::uint64_t bytes_of(const ActionRecord& r) {
  std::uint64_t sum = 0;
  for (const auto& [port, o] : r.outputs) sum += o.bytes;
  return sum;
}

void last_time(Plan::Node& node, const HistoryEntry& before, Store& store) {
  Tier tier;
  if (const auto record = store.find_action(Hash::parse(before.key), tier)) {
    node.seconds = record->seconds;
    node.bytes = bytes_of(*record);
  }
}

// A cached node runs anyway if the cache has lost its value and a node that runs needs it.
void add_lost_values(const Graph& graph, Store& store, const std::vector<NodeResult>& results, Plan& plan) {
  for (std::size_t i = graph.nodes.size(); i-- > 0;) {  // consumers come after their sources
    const Step step = plan.nodes[i].step;
    if (step != Step::Compute && step != Step::Perhaps) continue;
    for (const auto& [port, wires] : graph.nodes[i].inputs)
      for (const auto& w : wires) {
        const std::size_t source = w.node;
        Plan::Node& p = plan.nodes[source];
        if (p.step != Step::Cached || store.has_value(results[source].outputs.at(w.port))) continue;
        p.step = step;
        p.reasons.push_back(
            fmt::format("its {} was evicted from the cache, and {} needs it", w.port, graph.nodes[i].path));
      }
  }
}

// Plans a node behind nodes that will run. The new content of its inputs is unknown, so everything else is
// compared.
void plan_downstream(const GraphNode& node, const std::set<std::string>& running,
                     const std::optional<HistoryEntry>& before, const std::vector<NodeResult>& results,
                     FileHashes& hashes, Store& store, Plan::Node& out) {
  out.step = Step::Perhaps;
  if (before) {
    HistoryEntry now = history_entry(node, results, hashes, {});
    now.inputs = before->inputs;
    compare(node, *before, now, out.reasons);
    if (!out.reasons.empty()) out.step = Step::Compute;
    last_time(out, *before, store);
  } else {
    out.step = Step::Compute;
    out.reasons.push_back("never computed here");
  }
  out.reasons.push_back(fmt::format("downstream of {}", fmt::join(running, ", ")));
}

// Compares the files that a node wrote with its record.
void compare_files(const ActionRecord& record, const std::filesystem::path& folder, FileHashes& hashes,
                   std::vector<std::string>& reasons) {
  for (const auto& f : record.files) {
    const auto now = hashes.hash(folder / f.path);
    if (!now || *now != f.content)
      reasons.push_back(
          fmt::format("the file '{}' {}", (folder / f.path).string(), now ? "was changed" : "is missing"));
  }
}

}  // namespace

Plan plan_run(const Graph& graph, const RunOptions& options, Store& store, FileHashes& hashes,
              const History& history) {
  Plan plan;
  plan.nodes.resize(graph.nodes.size());
  std::vector<NodeResult> results(graph.nodes.size());
  const auto needed = needed_nodes(graph, options.targets.empty() ? graph.sinks() : options.targets);
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    if (!needed[i]) continue;
    const GraphNode& node = graph.nodes[i];
    Plan::Node& out = plan.nodes[i];
    std::map<std::string, std::vector<OutputRecord>> inputs;
    std::set<std::string> running;
    for (const auto& [port, wires] : node.inputs)
      for (const auto& w : wires) {
        const std::size_t source = w.node;
        if (plan.nodes[source].step == Step::Cached)
          inputs[port].push_back(results[source].outputs.at(w.port));
        else
          running.insert(graph.nodes[source].path);
      }
    const auto before = history.find(graph, node);
    if (!running.empty()) {
      plan_downstream(node, running, before, results, hashes, store, out);
      continue;
    }
    InputFiles files;
    try {
      files = input_files(node, hashes, options.memory);
    } catch (const Error& e) {
      out.step = Step::Compute;
      out.reasons.push_back("it will fail: " + e.diagnostic().message);
      continue;
    }
    const Hash key = action_key(node, files.hashes, inputs);
    Tier tier;
    const auto record = store.find_action(record_key(*node.type, key, options.output_folder), tier);
    out.step = Step::Cached;
    if (record && has_outputs_of(*record, *node.type)) {
      out.seconds = record->seconds;
      out.bytes = bytes_of(*record);
      compare_files(*record, options.output_folder, hashes, out.reasons);
      if (out.reasons.empty()) {
        results[i].outputs = record->outputs;
        continue;
      }
    } else if (!before) {
      out.reasons.push_back("never computed here");
    } else {
      last_time(out, *before, store);
      compare(node, *before, history_entry(node, results, hashes, key), out.reasons);
      if (out.reasons.empty()) out.reasons.push_back("its record was evicted from the cache");
    }
    out.step = Step::Compute;
  }
  add_lost_values(graph, store, results, plan);
  return plan;
}

}  // namespace terrazzo
