// Nodes that are added, changed, removed and renamed.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/describe.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"
#include "runtime/clients/python/edits.h"
#include "runtime/clients/python/graph_object.h"
#include "runtime/json_text.h"

namespace terrazzo::python {
namespace fs = std::filesystem;
namespace {

std::string snake_case(const std::string& name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool upper = name[i] >= 'A' && name[i] <= 'Z';
    const bool starts = upper && i > 0 && (name[i - 1] < 'A' || name[i - 1] > 'Z');
    if (starts) out += '_';
    out += upper ? static_cast<char>(name[i] - 'A' + 'a') : name[i];
  }
  return out;
}

// Undoes changes of the document unless keep() was called. Edits call no code of the user, so other threads
// have not changed it meanwhile.
class Undo {
 public:
  explicit Undo(RawDocument& document) : document_(document), nodes_(document.nodes.size()) {}
  ~Undo() {
    if (!keep_) document_.nodes.resize(nodes_);
  }
  void keep() { keep_ = true; }

 private:
  RawDocument& document_;
  std::size_t nodes_;
  bool keep_ = false;
};

// Sorts the entries of a new node as they are declared, as people write them.
void sort_entries(RawNode& node, const NodeType& type) {
  const auto sort = [](auto& list, const auto& declared) {
    const auto position = [&](const auto& entry) {
      return std::find_if(declared.begin(), declared.end(),
                          [&](const auto& d) { return d.name == entry.first; }) -
             declared.begin();
    };
    std::stable_sort(list.begin(), list.end(),
                     [&](const auto& a, const auto& b) { return position(a) < position(b); });
  };
  sort(node.inputs, type.inputs);
  sort(node.params, type.parameters);
}

// What a node is repeated for: a dictionary of lists, ranges or references.
std::vector<std::pair<std::string, RawValue>> each_of(const py::object& values, const Place& place) {
  std::vector<std::pair<std::string, RawValue>> out;
  if (values.is_none()) return out;
  if (!PyDict_Check(values.ptr()))
    throw Error(
        "bad-value",
        fmt::format("each is a dictionary of names and values, not a {}", Py_TYPE(values.ptr())->tp_name),
        "each={'k': range(4)}; parameters then contain \"${k}\"");
  for (const auto& [name, list] : py::reinterpret_borrow<py::dict>(values)) {
    if (!PyUnicode_Check(name.ptr())) throw Error("bad-value", "the names in each must be text");
    out.push_back({utf8(name), {written_values(list), place}});
  }
  return out;
}

}  // namespace

void GraphObject::apply(RawNode& node, const NodeType& type, const Edit& edit) {
  for (const auto& [name, value] : edit.values) try {
      if (name == "each") {
        node.each = each_of(value, edit.place);
        continue;
      }
      if (const Port* port = input_for(type, name, value)) {
        if (value.is_none())
          erase(node.inputs, name);
        else
          put(node.inputs, name, wires(node.name, *port, value, edit.place));
        continue;
      }
      const Parameter* p = type.find_parameter(name);
      if (!p) unknown_name(type, name);
      if (value.is_none()) {
        erase(node.params, name);
        continue;
      }
      RawValue raw{written_value(value), edit.place};
      make_absolute(*p, raw.written);
      check_value(*p, raw.written);
      put(node.params, name, std::move(raw));
    } catch (const Error& e) {
      Diagnostic d = e.diagnostic();
      d.node = node.name;
      d.place = edit.place;
      if (d.parameter.empty() && d.code == "bad-value") d.parameter = name;
      throw Error(d);
    }
  // Files that the node is repeated for.
  for (auto& [variable, values] : node.each)
    for (const auto& [name, value] : node.params)
      if (const Parameter* p = type.find_parameter(name);
          p && values.place.file == edit.place.file && value.written.text() == "${" + variable + "}")
        for (auto& item : values.written.items) {
          WrittenValue path{false, {item}, {}};
          make_absolute(*p, path);
          item = path.items[0];
        }
}

std::string GraphObject::add(const std::string& type_name, std::string name, const Edit& edit) {
  const NodeType* type = registry().find(type_name);
  if (!type)
    throw Error("unknown-type", fmt::format("there is no node type '{}'{}", type_name,
                                            did_you_mean(type_name, registry().names())));
  RawNode node;
  if (!name.empty()) {
    check_name(name);
    if (index_.count(name)) throw Error("duplicate-key", fmt::format("there is already a node '{}'", name));
  }
  node.name = name.empty() ? free_name(snake_case(type_name)) : name;
  node.type = type_name;
  node.place = node.kind_place = edit.place;
  Undo undo(document_);
  try {
    apply(node, *type, edit);
    sort_entries(node, *type);
  } catch (...) {
    reindex();
    throw;
  }
  undo.keep();
  if (index_.count(node.name)) node.name = free_name(node.name);  // a given value took it
  index_[node.name] = document_.nodes.size();
  document_.nodes.push_back(std::move(node));
  changed();
  return document_.nodes.back().name;
}

std::string GraphObject::add_subgraph(const fs::path& file, std::string name, const Edit& edit) {
  const fs::path absolute = fs::absolute(file).lexically_normal();
  const NodeType& type = subgraph_type(absolute);
  RawNode node;
  if (!name.empty()) {
    check_name(name);
    if (index_.count(name)) throw Error("duplicate-key", fmt::format("there is already a node '{}'", name));
  }
  node.name = name.empty() ? free_name(absolute.stem().string()) : name;
  node.graph = absolute.string();
  node.place = node.kind_place = edit.place;
  Undo undo(document_);
  try {
    apply(node, type, edit);
    sort_entries(node, type);
  } catch (...) {
    reindex();
    throw;
  }
  undo.keep();
  index_[node.name] = document_.nodes.size();
  document_.nodes.push_back(std::move(node));
  changed();
  return document_.nodes.back().name;
}

void GraphObject::set(const std::string& name, const Edit& edit) {
  const NodeType& type = type_of(name);
  if (!find(name)) return apply_inside(name, type, edit);
  RawNode node = *find(name);
  Undo undo(document_);
  try {
    apply(node, type, edit);
  } catch (...) {
    reindex();
    throw;
  }
  undo.keep();
  document_.nodes[index_.at(name)] = std::move(node);
  drop_unused_values();
  changed();
}

// Removes the nodes of arrays that nothing uses any more, so that replacing an array does not keep the old
// one.
void GraphObject::drop_unused_values() {
  if (given_.empty()) return;
  std::set<std::string> used;
  for (const auto& node : document_.nodes)
    for (const auto& [port, list] : node.inputs)
      for (const auto& w : list) used.insert(w.text);
  for (const auto* list : {&document_.outputs, &document_.inputs})
    for (const auto& [port, w] : *list) used.insert(w.text);
  for (const auto& [input, sources] : overrides_.wires) used.insert(sources.begin(), sources.end());
  std::erase_if(document_.nodes, [&](const RawNode& node) {
    if (!is_given_type(node.type) || used.count(node.name + ".value")) return false;
    given_.erase(node.params[0].second.written.items[0]);
    return true;
  });
  reindex();
}

// A node of a subgraph: its file stays as it is, and this graph overrides it.
void GraphObject::apply_inside(const std::string& name, const NodeType& type, const Edit& edit) {
  const Overrides before = overrides_;
  const auto text = [](const WrittenValue& v) {  // JSON is valid YAML
    return v.is_list ? json_text(nlohmann::json(v.items)) : json_text(nlohmann::json(v.items.at(0)));
  };
  for (const auto& [key, value] : edit.values) {
    const std::string target = name + "." + key;
    if (const Port* port = input_for(type, key, value)) {
      std::vector<std::string> sources;
      if (!value.is_none())
        for (const auto& w : wires(name, *port, value, edit.place)) sources.push_back(w.text);
      put(overrides_.wires, target, sources);
      continue;
    }
    const Parameter* p = type.find_parameter(key);
    if (!p) unknown_name(type, key);
    if (value.is_none()) {
      erase(overrides_.set, target);
      continue;
    }
    WrittenValue v = written_value(value);
    make_absolute(*p, v);
    check_value(*p, v);
    put(overrides_.set, target, text(v));
  }
  changed();
  try {
    link();
  } catch (...) {
    overrides_ = before;
    changed();
    throw;
  }
}

void GraphObject::remove(const std::string& name) {
  type_of(name);
  if (!find(name)) throw Error("unknown-node", fmt::format("'{}' is inside a subgraph", name));
  for (const auto& node : document_.nodes)
    for (const auto& [port, list] : node.inputs)
      for (const auto& w : list)
        if (written_node(w.text) == name && node.name != name)
          throw Error("in-use", fmt::format("'{}' is connected to '{}.{}'", w.text, node.name, port),
                      "disconnect it first: node.set(INPUT=None)");
  for (const auto* list : {&document_.outputs, &document_.inputs})
    for (const auto& [port, w] : *list)
      if (written_node(w.text) == name)
        throw Error("in-use", fmt::format("'{}' is connected to '{}' of the graph", w.text, port),
                    "remove it first: graph.output(NAME, None)");
  document_.nodes.erase(document_.nodes.begin() + index_.at(name));
  reindex();
  drop_unused_values();
  changed();
}

void GraphObject::rename(const std::string& name, const std::string& fresh) {
  type_of(name);
  if (!find(name)) throw Error("unknown-node", fmt::format("'{}' is inside a subgraph", name));
  check_name(fresh);
  if (index_.count(fresh)) throw Error("duplicate-key", fmt::format("there is already a node '{}'", fresh));
  const auto follow = [&](RawReference& w) {
    if (written_node(w.text) == name) w.text = fresh + w.text.substr(name.size());
  };
  for (auto& node : document_.nodes)
    for (auto& [port, list] : node.inputs)
      for (auto& w : list) follow(w);
  for (auto* list : {&document_.outputs, &document_.inputs})
    for (auto& [port, w] : *list) follow(w);
  document_.nodes[index_.at(name)].name = fresh;
  reindex();
  changed();
}

}  // namespace terrazzo::python
