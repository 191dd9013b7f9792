// What Python connects to inputs: outputs, nodes and values.
#include <fmt/format.h>

#include "runtime/clients/python/edits.h"
#include "runtime/clients/python/graph_object.h"

namespace terrazzo::python {

std::string GraphObject::give(const Value& value, const std::string& like, const Place& place) {
  const auto kept = give_value(value);
  const std::string type = given_type(value.type().name);
  for (const auto& node : document_.nodes)
    if (node.type == type && !node.params.empty() && node.params[0].second.written.items[0] == kept->content)
      return node.name + ".value";
  RawNode node;
  node.name = free_name(like);
  node.place = node.kind_place = place;
  node.type = type;
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

}  // namespace

const Port* input_for(const NodeType& type, const std::string& name, const py::object& value) {
  const Port* port = type.find_input(name);
  if (!port || !type.find_parameter(name) || is_source(value)) return port;
  if ((PyList_Check(value.ptr()) || PyTuple_Check(value.ptr())) && py::len(value) > 0 &&
      is_source(value[py::int_(0)]))
    return port;
  return nullptr;
}

}  // namespace terrazzo::python
