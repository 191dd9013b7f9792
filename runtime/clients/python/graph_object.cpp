#include "runtime/clients/python/graph_object.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/describe.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"
#include "runtime/bundle/bundle.h"
#include "runtime/cache/action_key.h"
#include "runtime/clients/python/outside.h"

namespace terrazzo::python {
namespace fs = std::filesystem;
namespace {

void throw_if_wrong(const Diagnostics& found) {
  for (const auto& d : found)
    if (d.severity == Severity::Error) raise(found);
}

}  // namespace

GraphObject::~GraphObject() {
  if (!session_) return;
  if (process_was_forked()) {  // the session would wait for threads that do not exist here
    session_.release();
    return;
  }
  const Outside outside;  // nodes written in Python need it to end
  session_.reset();
}

Session& GraphObject::session() {
  if (!session_) session_ = std::make_unique<Session>(registry(), value_types(), options_);
  return *session_;
}

void GraphObject::reindex() {
  index_.clear();
  for (std::size_t i = 0; i < document_.nodes.size(); ++i) index_[document_.nodes[i].name] = i;
}

void GraphObject::open(const fs::path& given) {
  Diagnostics found;
  const fs::path file = is_bundle(given) ? open_bundle(given, registry()) : given;
  const auto text = read_graph_text(file, found);
  if (!text) raise(found);
  open_text(*text, file);
}

void GraphObject::open_text(const std::string& text, const fs::path& file) {
  Diagnostics found;
  RawDocument doc = read_document(text, file.empty() ? file : fs::absolute(file).lexically_normal(), found);
  if (has_errors(found)) {
    link_document(std::move(doc), registry(), {}, found);  // finds the other errors too
    raise(found);
  }
  if (doc.file.empty()) doc.file = document_.file;
  document_ = std::move(doc);
  original_ = text;
  overrides_ = {};
  opened_ = file.empty() ? fs::path() : document_.file;
  given_.clear();
  for (const RawNode& node : document_.nodes)
    if (is_given_type(node.type) && !node.params.empty())
      if (auto value = find_given(node.params[0].second.written.text())) given_[value->content] = value;
  reindex();
  changed();
}

const RawNode* GraphObject::find(const std::string& node) const {
  const auto it = index_.find(node);
  return it == index_.end() ? nullptr : &document_.nodes[it->second];
}

const RawNode* GraphObject::find_written(const std::string& node) const {
  if (const RawNode* raw = find(node)) return raw;
  const RawNode* raw = find(without_elements(node));
  return raw && !raw->each.empty() ? raw : nullptr;
}

const NodeType& GraphObject::subgraph_type(const fs::path& file) {
  auto& type = subgraph_types_[file.string()];
  if (!type) {
    Diagnostics found;
    const Graph graph = load_graph(file, registry(), {}, found);
    // Parameters without a default are errors in the file itself, but not where it is used.
    std::erase_if(found, [](const Diagnostic& d) { return d.code == "missing-parameter"; });
    throw_if_wrong(found);
    type = std::make_shared<NodeType>(describe_graph(graph));
    if (type->name.empty()) type->name = file.stem().string();
  }
  return *type;
}

const NodeType& GraphObject::type_of(const std::string& node) {
  if (const RawNode* raw = find_written(node)) {
    if (!raw->graph.empty())
      return subgraph_type((document_.file.parent_path() / raw->graph).lexically_normal());
    const NodeType* type = registry().find(raw->type);
    if (!type) type = registry().find_former(raw->type);
    if (type) return *type;
    throw Error("unknown-type", fmt::format("there is no node type '{}'{}", raw->type,
                                            did_you_mean(raw->type, registry().names())));
  }
  if (node.find('/') != std::string::npos) {
    link();
    const auto graph = session().graph();
    if (const int i = graph->find(node); i >= 0) return *graph->nodes[i].type;
  }
  std::vector<std::string> names;
  for (const auto& n : document_.nodes) names.push_back(n.name);
  throw Error("unknown-node", fmt::format("there is no node '{}'{}", node, did_you_mean(node, names)));
}

std::string GraphObject::free_name(const std::string& like) const {
  if (!index_.count(like)) return like;
  const auto name = [&](int k) { return fmt::format("{}_{}", like, k); };
  // Numbers are mostly taken from 2 on, so this finds the first free one without trying them all.
  int taken = 1, free = 2;
  while (index_.count(name(free))) {
    taken = free;
    free *= 2;
  }
  while (free - taken > 1) (index_.count(name((taken + free) / 2)) ? taken : free) = (taken + free) / 2;
  return name(free);
}

std::vector<std::pair<std::string, WrittenValue>> GraphObject::each(const std::string& node) {
  type_of(node);
  std::vector<std::pair<std::string, WrittenValue>> out;
  if (const RawNode* raw = find(node))
    for (const auto& [name, value] : raw->each) out.emplace_back(name, value.written);
  return out;
}

bool GraphObject::is_list(const std::string& output) const {
  std::string reference = output;
  for (const auto& [name, w] : document_.outputs)
    if (name == output) reference = w.text;
  const RawNode* raw = find(reference.substr(0, find_port_dot(reference)));
  return raw && !raw->each.empty();
}

const Diagnostics& GraphObject::link() {
  if (linked_ == revision_) return found_;
  RawDocument document = document_;
  for (const auto& output : inner_outputs_) {
    const std::string node = output.substr(0, find_port_dot(output));
    if (const RawNode* raw = find_written(node); raw && (!raw->graph.empty() || !raw->each.empty()))
      document.outputs.push_back({output, {output, raw->place}});
  }
  Diagnostics found = session().open_document(std::move(document), overrides_);
  throw_if_wrong(found);
  found_ = std::move(found);
  linked_ = revision_;
  return found_;
}

std::vector<std::string> GraphObject::targets(const std::vector<std::string>& given) {
  // The linker dissolves subgraphs and repeated nodes. It resolves an output of one if it is an output of the
  // whole.
  std::vector<std::string> out;
  const auto add = [&](const std::string& output) {
    if (inner_outputs_.insert(output).second) changed();
    out.push_back(output);
  };
  for (const auto& target : given) {
    const RawNode* whole = find_written(target);
    const RawNode* part = find_written(target.substr(0, find_port_dot(target)));
    if (whole && !whole->graph.empty())
      for (const auto& port : type_of(target).outputs) add(target + "." + port.name);
    else if (part && (!part->graph.empty() || is_list(target)))
      add(target);
    else
      out.push_back(target);
  }
  link();
  if (!given.empty() || inner_outputs_.empty()) return out;
  Graph graph = *session().graph();  // the default targets, without these outputs
  std::erase_if(graph.outputs, [&](const GraphOutput& o) { return inner_outputs_.count(o.name) > 0; });
  for (const int sink : graph.sinks()) out.push_back(graph.nodes[sink].path);
  return out;
}

Value GraphObject::known(const std::string& output) {
  const auto it = known_.find(output);
  if (it == known_.end() || it->second.revision != revision_ || !session_) return {};
  const Known& k = it->second;
  try {
    for (const auto& [node, reads] : k.reads)
      if (input_files(k.graph->nodes[node], session_->evaluator().hashes()).read != reads) return {};
  } catch (const Error&) {
    return {};  // the evaluation reports it
  }
  const OutputRecord record = k.record;  // another thread may replace it once the GIL is released
  Store& store = session_->evaluator().store();
  const Outside outside;
  return store.get_value(record);
}

void GraphObject::remember(const std::string& output, std::uint64_t revision, const Graph& graph,
                           const RunResult& result, const Wire& wire) {
  Known k;
  k.revision = revision;
  k.graph = session().graph();
  if (k.graph.get() != &graph) return;  // changed meanwhile
  k.record = result.nodes[wire.node].outputs.at(wire.port);
  const auto needed = needed_nodes(graph, {wire.node});
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (needed[i] && !result.nodes[i].read.empty())
      k.reads.emplace_back(static_cast<int>(i), result.nodes[i].read);
  known_[output] = std::move(k);
}

}  // namespace terrazzo::python
