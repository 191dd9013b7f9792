#include "runtime/python/graph_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/describe.h"
#include "graph/element_name.h"
#include "graph/nearest.h"
#include "graph/write_document.h"
#include "runtime/action_key.h"
#include "runtime/json_text.h"

namespace terrazzo::python {
namespace fs = std::filesystem;
namespace {

void throw_if_wrong(const Diagnostics& found) {
  for (const auto& d : found)
    if (d.severity == Severity::Error) raise(found);
}

bool is_reference(const std::string& text) { return text.find("${") != std::string::npos; }

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

template <class Item>
void put(std::vector<std::pair<std::string, Item>>& list, const std::string& name, Item value) {
  for (auto& [known, v] : list)
    if (known == name) {
      v = std::move(value);
      return;
    }
  list.emplace_back(name, std::move(value));
}

template <class Item>
void erase(std::vector<std::pair<std::string, Item>>& list, const std::string& name) {
  std::erase_if(list, [&](const auto& entry) { return entry.first == name; });
}

// Paths that the user gives are relative to the working folder now, wherever the graph is saved later.
void make_absolute(const Parameter& p, WrittenValue& v) {
  if (p.kind != ParameterKind::InputPath || v.is_list || v.items.empty()) return;
  std::string& path = v.items[0];
  if (path.empty() || is_reference(path)) return;
  if (std::find(p.keywords.begin(), p.keywords.end(), path) != p.keywords.end()) return;
  if (path[0] == '~' && (path.size() == 1 || path[1] == '/'))
    throw Error("bad-value", fmt::format("'{}' starts with ~, which is not expanded", path),
                "use os.path.expanduser");
  path = fs::absolute(path).lexically_normal().string();
}

// Checks a value as the linker does, unless it refers to a parameter of the graph.
void check_value(const Parameter& p, const WrittenValue& v) {
  if (std::any_of(v.items.begin(), v.items.end(), is_reference)) return;
  std::string why;
  if (!read_parameter(p, v, why)) throw Error("bad-value", why).parameter(p.name);
}

[[noreturn]] void unknown_name(const NodeType& type, const std::string& name) {
  std::vector<std::string> names;
  for (const auto& p : type.inputs) names.push_back(p.name);
  for (const auto& p : type.parameters) names.push_back(p.name);
  throw Error("unknown-parameter",
              fmt::format("{} has no input or parameter '{}'{}", type.name, name, did_you_mean(name, names)));
}

}  // namespace

WrittenValue written_value(const py::handle& h) {
  const auto scalar = [](const py::handle& v) -> std::optional<std::string> {
    if (PyBool_Check(v.ptr())) return v.ptr() == Py_True ? "true" : "false";
    if (PyUnicode_Check(v.ptr())) return v.cast<std::string>();
    if (PyLong_Check(v.ptr())) return py::str(v).cast<std::string>();
    if (PyFloat_Check(v.ptr())) return fmt::format("{}", v.cast<double>());
    if (py::isinstance<ParameterReference>(v)) return "${" + v.cast<const ParameterReference&>().name + "}";
    if (py::hasattr(v, "__fspath__")) return py::str(v.attr("__fspath__")()).cast<std::string>();
    if (py::hasattr(v, "dtype") && py::hasattr(v, "item") && py::hasattr(v, "ndim") &&
        v.attr("ndim").cast<int>() == 0) {  // a number of numpy
      const py::object item = v.attr("item")();
      if (PyBool_Check(item.ptr())) return item.ptr() == Py_True ? "true" : "false";
      if (PyFloat_Check(item.ptr())) return fmt::format("{}", item.cast<double>());
      return py::str(item).cast<std::string>();
    }
    return {};
  };
  if (const auto one = scalar(h)) return {false, {*one}, {}};
  const bool list = PyList_Check(h.ptr()) || PyTuple_Check(h.ptr()) || py::isinstance<py::array>(h);
  if (list) {
    WrittenValue out{true, {}, {}};
    for (const auto& item : py::reinterpret_borrow<py::object>(h)) {
      const auto one = scalar(item);
      if (!one)
        throw Error("bad-value", fmt::format("a list contains a {}; only numbers and text are values",
                                             Py_TYPE(item.ptr())->tp_name));
      out.items.push_back(*one);
    }
    return out;
  }
  throw Error("bad-value", fmt::format("a {} cannot be the value of a parameter", Py_TYPE(h.ptr())->tp_name),
              "use numbers, text, booleans, lists of them, paths, or a parameter of the graph");
}

GraphObject::~GraphObject() {
  if (!session_) return;
  if (process_was_forked()) {  // the session would wait for threads that do not exist here
    session_.release();
    return;
  }
  const py::gil_scoped_release without_gil;  // nodes written in Python need it to end
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

void GraphObject::open(const fs::path& file) {
  Diagnostics found;
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
  document_ = std::move(doc), original_ = text, overrides_ = {};
  opened_ = file.empty() ? fs::path() : document_.file;
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
    if (const int i = graph->find(node); i >= 0) return *graph->nodes[static_cast<std::size_t>(i)].type;
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
  while (index_.count(name(free))) taken = free, free *= 2;
  while (free - taken > 1) (index_.count(name((taken + free) / 2)) ? taken : free) = (taken + free) / 2;
  return name(free);
}

std::string GraphObject::give(const Value& value, const std::string& like, const Place& place) {
  const auto kept = give_value(value);
  const std::string type = given_type(value.type().name);
  for (const auto& node : document_.nodes)
    if (node.type == type && !node.params.empty() && node.params[0].second.written.items[0] == kept->content)
      return node.name + ".value";
  RawNode node;
  node.name = free_name(like), node.place = node.kind_place = place, node.type = type;
  node.params.push_back({"content", {{false, {kept->content}, {}}, place}});
  given_[kept->content] = kept;
  index_[node.name] = document_.nodes.size();
  document_.nodes.push_back(node);
  return node.name + ".value";
}

std::string GraphObject::output_of(const py::handle& h, const Port& port, const std::string& node) {
  const auto here = [&](const py::object& graph) {
    if (graph.cast<const GraphObject*>() != this)
      throw Error("other-graph",
                  fmt::format("the input '{}' of '{}' is connected to another graph", port.name, node),
                  "evaluate the other graph and pass the value");
  };
  if (py::isinstance<OutputObject>(h)) {
    const auto& out = h.cast<const OutputObject&>();
    here(out.graph);
    const NodeType& source = type_of(out.node);  // it may have been removed
    if (!source.find_output(out.port))
      throw Error("unknown-port", fmt::format("'{}' has no output '{}'", out.node, out.port));
    if (!port.accepts(out.type))
      throw Error("wrong-type", fmt::format("the input '{}' takes {}, but {} is a {}", port.name,
                                            port.type_text(), out.text(), out.type));
    return out.text();
  }
  if (py::isinstance<NodeObject>(h)) {
    const auto& n = h.cast<const NodeObject&>();
    here(n.graph);
    const NodeType& source = type_of(n.name);
    std::vector<const Port*> fits;
    for (const auto& o : source.outputs)
      if (port.accepts(o.types[0])) fits.push_back(&o);
    if (fits.size() != 1)
      throw Error("wrong-type",
                  fmt::format("the input '{}' takes {}; '{}' has {} outputs of that type", port.name,
                              port.type_text(), n.name, fits.size()),
                  "name the output: node.OUTPUT");
    return n.name + "." + fits[0]->name;
  }
  if (is_value(h)) {
    const Value& v = to_value(h);
    if (!port.accepts(v.type().name))
      throw Error("wrong-type", fmt::format("the input '{}' takes {}, but it is given a {}", port.name,
                                            port.type_text(), v.type().name));
    return give(v, port.name, callers_place());
  }
  throw Error(
      "wrong-type",
      fmt::format("the input '{}' takes {}, not a {}", port.name, port.type_text(),
                  Py_TYPE(h.ptr())->tp_name),
      "connect an output of a node, or a value: terrazzo.image, labels, mesh and sizes make values of "
      "arrays");
}

std::vector<RawReference> GraphObject::wires(const std::string& node, const Port& port,
                                             const py::object& value, const Place& place) {
  std::vector<RawReference> out;
  if (PyList_Check(value.ptr()) || PyTuple_Check(value.ptr())) {
    if (!port.many)
      throw Error("too-many-wires",
                  fmt::format("the input '{}' of '{}' takes one value, not a list", port.name, node));
    for (const auto& item : value) out.push_back({output_of(item, port, node), place});
    if (out.empty())
      throw Error("missing-input", fmt::format("the list for the input '{}' is empty", port.name));
  } else {
    out.push_back({output_of(value, port, node), place});
  }
  return out;
}

namespace {

bool is_source(const py::handle& h) {
  return py::isinstance<OutputObject>(h) || py::isinstance<NodeObject>(h) || is_value(h);
}

// The input of this name, unless there is also a parameter of this name and the value is one for it: outputs
// and values go to the input, everything else to the parameter.
const Port* input_for(const NodeType& type, const std::string& name, const py::object& value) {
  const Port* port = type.find_input(name);
  if (!port || !type.find_parameter(name) || is_source(value)) return port;
  if ((PyList_Check(value.ptr()) || PyTuple_Check(value.ptr())) && py::len(value) > 0 &&
      is_source(value[py::int_(0)]))
    return port;
  return nullptr;
}

}  // namespace

void GraphObject::apply(RawNode& node, const NodeType& type, const Edit& edit) {
  for (const auto& [name, value] : edit.values) try {
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
      d.node = node.name, d.place = edit.place;
      if (d.parameter.empty() && d.code == "bad-value") d.parameter = name;
      throw Error(d);
    }
}

namespace {

// Undoes changes of the document unless keep() was called.
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

void check_name(const std::string& name) {
  if (name.empty() || name.find_first_of(". /\n") != std::string::npos)
    throw Error(
        "bad-name",
        fmt::format("'{}' is not a valid name: it must not be empty or contain dots, slashes or spaces",
                    name));
}

}  // namespace

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
  node.type = type_name, node.place = node.kind_place = edit.place;
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
  node.graph = absolute.string(), node.place = node.kind_place = edit.place;
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
  document_.nodes.erase(document_.nodes.begin() + static_cast<std::ptrdiff_t>(index_.at(name)));
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

void GraphObject::add_parameter(RawParameter p) {
  check_name(p.declaration.name);
  for (const auto& known : document_.parameters)
    if (known.declaration.name == p.declaration.name)
      throw Error("duplicate-key", fmt::format("there is already a parameter '{}'", p.declaration.name));
  if (!p.value.written.items.empty()) {
    make_absolute(p.declaration, p.value.written);
    check_value(p.declaration, p.value.written);
  }
  document_.parameters.push_back(std::move(p));
  changed();
}

void GraphObject::set_parameter(const std::string& name, const py::object& value, const Place& place) {
  std::vector<std::string> names;
  for (auto& p : document_.parameters) {
    names.push_back(p.declaration.name);
    if (p.declaration.name != name) continue;
    RawValue raw{written_value(value), place};
    make_absolute(p.declaration, raw.written);
    try {
      check_value(p.declaration, raw.written);
    } catch (const Error& e) {
      Diagnostic d = e.diagnostic();
      d.place = place;
      throw Error(d);
    }
    p.value = std::move(raw);
    return changed();
  }
  throw Error("unknown-parameter",
              fmt::format("the graph has no parameter '{}'{}", name, did_you_mean(name, names)));
}

void GraphObject::set_port(bool output, const std::string& name, const std::string& reference,
                           const Place& place) {
  check_name(name);
  auto& list = output ? document_.outputs : document_.inputs;
  if (reference.empty())
    erase(list, name);
  else
    put(list, name, RawReference{reference, place});
  changed();
}

void GraphObject::set_name(const std::string& name, const std::string& doc) {
  document_.name = name, document_.doc = doc;
  changed();
}

py::object GraphObject::parameter(const std::string& node, const std::string& name) {
  const NodeType& type = type_of(node);
  const Parameter* p = type.find_parameter(name);
  if (!p) unknown_name(type, name);
  std::optional<ParameterValue> value = p->value;
  if (const RawNode* raw = find(node)) {
    for (const auto& [key, v] : raw->params) {
      if (key != name) continue;
      if (std::any_of(v.written.items.begin(), v.written.items.end(), is_reference))
        return v.written.is_list ? py::cast(v.written.items) : py::object(py::str(v.written.text()));
      std::string why;
      value = read_parameter(*p, v.written, why);
    }
  } else {
    link();
    const auto graph = session().graph();
    const int at = graph->find(node);
    if (at < 0)
      throw Error("unknown-node", fmt::format("'{}' is an element of a subgraph", node),
                  "read the parameters of the nodes inside it");
    const auto& set = graph->nodes[static_cast<std::size_t>(at)].parameters;
    if (const auto it = set.find(name); it != set.end()) value = it->second.value;
  }
  return value ? py::cast(*value) : py::none();
}

py::object GraphObject::written_parameter(const std::string& node, const std::string& name) {
  if (!type_of(node).find_parameter(name)) unknown_name(type_of(node), name);
  std::optional<WrittenValue> written;
  if (const RawNode* raw = find(node)) {
    for (const auto& [key, v] : raw->params)
      if (key == name) written = v.written;
  } else {
    for (const auto& [target, text] : overrides_.set)
      if (target == node + "." + name) written = read_written(text);
  }
  if (!written) return py::none();
  return written->is_list ? py::cast(written->items) : py::object(py::str(written->text()));
}

const Diagnostics& GraphObject::link() {
  if (linked_ == revision_) return found_;
  RawDocument document = document_;
  for (const auto& output : inner_outputs_) {
    const std::string node = output.substr(0, find_port_dot(output));
    if (const RawNode* raw = find_written(node); raw && !raw->graph.empty())
      document.outputs.push_back({output, {output, raw->place}});
  }
  Diagnostics found = session().open_document(std::move(document), overrides_);
  throw_if_wrong(found);
  found_ = std::move(found), linked_ = revision_;
  return found_;
}

std::vector<std::string> GraphObject::targets(const std::vector<std::string>& given) {
  // The linker dissolves subgraphs. It resolves an output of a subgraph if it is an output of the whole.
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
    else if (part && !part->graph.empty())
      add(target);
    else
      out.push_back(target);
  }
  link();
  if (!given.empty() || inner_outputs_.empty()) return out;
  Graph graph = *session().graph();  // the default targets, without these outputs
  std::erase_if(graph.outputs, [&](const GraphOutput& o) { return inner_outputs_.count(o.name) > 0; });
  for (const int sink : graph.sinks()) out.push_back(graph.nodes[static_cast<std::size_t>(sink)].path);
  return out;
}

std::string GraphObject::text(const fs::path& folder) const {
  std::vector<std::string> given;
  for (const auto& node : document_.nodes)
    if (is_given_type(node.type)) given.push_back(node.name);
  if (!given.empty())
    throw Error("not-savable",
                fmt::format("a graph file cannot hold the arrays of the nodes {}", fmt::join(given, ", ")),
                "write them to files (value.save) and load these with LoadImage, LoadLabels or LoadMesh");
  if (!overrides_.set.empty() || !overrides_.wires.empty())
    throw Error("not-savable", "a graph file cannot record changes of nodes inside subgraphs",
                "add a parameter to the subgraph's file");
  // Paths that were read from the file are relative to its folder; those set here are absolute.
  const fs::path to = fs::absolute(folder).lexically_normal(), from = opened_.parent_path();
  const auto moved = [&](std::string& path, bool ours) {
    if (path.empty() || path.rfind("${", 0) == 0) return;
    const fs::path p = path;
    if (p.is_absolute() && !ours) return;
    const fs::path near = (p.is_absolute() ? p : from / p).lexically_normal().lexically_relative(to);
    if (!near.empty()) path = near.generic_string();
  };
  RawDocument doc = document_;
  const auto ours = [&](const Place& place) { return opened_.empty() || place.file != opened_.string(); };
  const bool same_folder = !from.empty() && from == to;
  const auto move_value = [&](const Parameter& p, RawValue& v) {
    if (p.kind != ParameterKind::InputPath || v.written.is_list || v.written.items.empty()) return;
    const std::string& path = v.written.items[0];
    if (std::find(p.keywords.begin(), p.keywords.end(), path) != p.keywords.end()) return;
    if (ours(v.place) || !same_folder) moved(v.written.items[0], ours(v.place));
  };
  for (auto& p : doc.parameters) move_value(p.declaration, p.value);
  for (auto& node : doc.nodes) {
    std::shared_ptr<const NodeType> sub;
    const NodeType* type = registry().find(node.type);
    if (!type) type = registry().find_former(node.type);
    if (!node.graph.empty()) {
      Diagnostics ignored;
      const Graph graph = load_graph((from / node.graph).lexically_normal(), registry(), {}, ignored);
      sub = std::make_shared<NodeType>(describe_graph(graph));
      type = sub.get();
      if (ours(node.kind_place) || !same_folder) moved(node.graph, ours(node.kind_place));
    }
    for (auto& [name, value] : node.params)
      if (const Parameter* p = type ? type->find_parameter(name) : nullptr) {
        move_value(*p, value);
        for (auto& [variable, values] : node.each)  // files that the node is repeated for
          if (p->kind == ParameterKind::InputPath && value.written.text() == "${" + variable + "}" &&
              (ours(values.place) || !same_folder))
            for (auto& path : values.written.items) moved(path, ours(values.place));
      }
  }
  return write_document(doc, original_);
}

Value GraphObject::known(const std::string& output) {
  const auto it = known_.find(output);
  if (it == known_.end() || it->second.revision != revision_ || !session_) return {};
  const Known& k = it->second;
  try {
    for (const auto& [node, reads] : k.reads)
      if (input_files(k.graph->nodes[static_cast<std::size_t>(node)], session_->evaluator().hashes()).read !=
          reads)
        return {};
  } catch (const Error&) {
    return {};  // the evaluation reports it
  }
  const py::gil_scoped_release without_gil;
  return session_->evaluator().store().get_value(k.record);
}

void GraphObject::remember(const std::string& output, std::uint64_t revision, const Graph& graph,
                           const RunResult& result, const Wire& wire) {
  Known k;
  k.revision = revision, k.graph = session().graph();
  if (k.graph.get() != &graph) return;  // changed meanwhile
  k.record = result.nodes[static_cast<std::size_t>(wire.node)].outputs.at(wire.port);
  const auto needed = needed_nodes(graph, {wire.node});
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (needed[i] && !result.nodes[i].read.empty())
      k.reads.emplace_back(static_cast<int>(i), result.nodes[i].read);
  known_[output] = std::move(k);
}

}  // namespace terrazzo::python
