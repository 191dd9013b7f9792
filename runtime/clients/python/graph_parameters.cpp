// Parameters, outputs and inputs of a graph, and parameters of its nodes.
#include <fmt/format.h>

#include <algorithm>

#include "graph/text/nearest.h"
#include "runtime/clients/python/edits.h"
#include "runtime/clients/python/graph_object.h"

namespace terrazzo::python {

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
  document_.name = name;
  document_.doc = doc;
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
    const auto& set = graph->nodes[at].parameters;
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

}  // namespace terrazzo::python
