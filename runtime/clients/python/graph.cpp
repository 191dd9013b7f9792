// The classes Graph, Node and Output.
#include <fmt/format.h>

#include <algorithm>

#include "graph/describe.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"
#include "runtime/clients/python/graph_object.h"
#include "runtime/clients/python/outside.h"
#include "runtime/files.h"
#include "runtime/report/explain.h"

namespace terrazzo::python {
namespace fs = std::filesystem;
namespace {

GraphObject::Edit edit_of(const py::dict& values) {
  // A parameter such as `class` is written class_, since Python reserves the word.
  static const auto& reserved =
      *new auto(py::module_::import("keyword").attr("kwlist").cast<std::vector<std::string>>());
  const auto is_reserved = [](const std::string& word) {
    return std::find(reserved.begin(), reserved.end(), word) != reserved.end();
  };
  GraphObject::Edit edit{{}, callers_place()};
  for (const auto& [key, value] : values) {
    std::string name = utf8(key);
    if (name.size() > 1 && name.back() == '_' && is_reserved(name.substr(0, name.size() - 1)))
      name.pop_back();
    edit.values[name] = plain(py::reinterpret_borrow<py::object>(value));
  }
  return edit;
}

// Takes the node's name out of the keyword arguments of a call.
std::string take_name(const py::dict& values) {
  if (!values.contains("name")) return {};
  const py::object name = values["name"];
  PyDict_DelItemString(values.ptr(), "name");
  if (name.is_none()) return {};
  if (!py::isinstance<py::str>(name)) throw Error("bad-name", "the name of a node must be text");
  return utf8(name);
}

GraphObject& graph_of(const py::object& graph) { return graph.cast<GraphObject&>(); }

OutputObject output(const NodeObject& node, const std::string& port) {
  const NodeType& type = graph_of(node.graph).type_of(node.name);
  const Port* p = type.find_output(port);
  if (!p) p = type.find_former_output(port);
  if (p) return {node.graph, node.name, p->name, p->types[0]};
  std::vector<std::string> names;
  for (const auto& o : type.outputs) names.push_back(o.name);
  throw py::attribute_error(fmt::format(
      "{} '{}' has no output '{}'{}{}", type.name, node.name, port, did_you_mean(port, names),
      type.find_parameter(port) ? fmt::format("; read the parameter with node['{}']", port) : ""));
}

OutputObject output_at(const py::object& graph, const std::string& reference) {
  const auto dot = find_port_dot(reference);
  const std::string node = reference.substr(0, dot);
  const NodeType& type = graph_of(graph).type_of(node);
  if (dot == std::string::npos && type.outputs.size() == 1)
    return {graph, node, type.outputs[0].name, type.outputs[0].types[0]};
  return output({graph, node}, dot == std::string::npos ? "" : reference.substr(dot + 1));
}

py::list parameters(const GraphObject& g) {
  py::list out;
  for (const auto& p : g.document().parameters) {
    py::dict d;
    d["name"] = p.declaration.name;
    d["type"] = name_of(p.declaration.kind);
    d["doc"] = p.declaration.doc;
    d["unit"] = p.declaration.unit;
    d["value"] = p.value.written.is_list         ? py::object(py::cast(p.value.written.items))
                 : p.value.written.items.empty() ? py::object(py::none())
                                                 : py::object(py::str(p.value.written.text()));
    out.append(d);
  }
  return out;
}

void add_parameter(GraphObject& g, const std::string& name, const std::string& type, const py::object& value,
                   const std::string& doc, const std::string& unit, const py::object& min,
                   const py::object& max, const std::vector<std::string>& choices,
                   const std::vector<std::string>& keywords) {
  RawParameter p;
  bool known = false;
  for (const auto kind :
       {ParameterKind::InputPath, ParameterKind::Int, ParameterKind::Number, ParameterKind::Bool,
        ParameterKind::Text, ParameterKind::Choice, ParameterKind::Color, ParameterKind::Numbers,
        ParameterKind::Ints, ParameterKind::Texts})
    if (name_of(kind) == type) {
      p.declaration.kind = kind;
      known = true;
    }
  if (!known)
    throw Error("unknown-type", fmt::format("a parameter cannot have the type '{}'", type),
                "use path, int, number, bool, text, choice, color, numbers, ints or texts");
  p.place = callers_place();
  p.declaration.name = name;
  p.declaration.doc = doc;
  p.declaration.unit = unit;
  if (!min.is_none()) p.declaration.min = min.cast<double>();
  if (!max.is_none()) p.declaration.max = max.cast<double>();
  p.declaration.choices = choices;
  p.declaration.keywords = keywords;
  if (!value.is_none()) p.value = {written_value(plain(value)), p.place};
  g.add_parameter(std::move(p));
}

py::list explain(GraphObject& g, const std::vector<std::string>& targets, const std::string& out) {
  const std::vector<std::string> known = g.targets(targets);
  Session& s = g.session();
  const auto graph = s.graph();
  RunOptions options;
  options.targets = target_nodes(*graph, known);
  options.output_folder = out;
  Plan plan;
  {
    const Outside outside;
    plan = plan_run(*graph, options, s.evaluator().store(), s.evaluator().hashes(), s.history());
  }
  py::list steps;
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    const auto& p = plan.nodes[i];
    const char* what = p.step == Plan::Step::Cached    ? "cached"
                       : p.step == Plan::Step::Compute ? "runs"
                       : p.step == Plan::Step::Perhaps ? "may run"
                                                       : nullptr;
    if (what) steps.append(py::make_tuple(graph->nodes[i].path, what, p.reasons, p.seconds, p.bytes));
  }
  return steps;
}

std::string draw(GraphObject& g, const std::string& format) {
  g.link();
  const auto graph = g.session().graph();
  if (format == "svg") return draw_svg(*graph);
  if (format == "dot") return draw_dot(*graph);
  if (format == "mermaid") return draw_mermaid(*graph);
  throw Error("bad-value", fmt::format("'{}' is not one of svg, dot, mermaid", format)).parameter("format");
}

void bind_outputs(py::module_& m) {
  py::class_<ParameterReference>(m, "ParameterReference",
                                 "A parameter of a graph as the value of a node's parameter.")
      .def_readonly("name", &ParameterReference::name)
      .def("__repr__", [](const ParameterReference& p) { return "${" + p.name + "}"; });

  py::class_<OutputObject>(
      m, "Output", "An output of a node. Connect it to inputs of other nodes, or evaluate it with value().")
      .def_readonly("graph", &OutputObject::graph, "The Graph.")
      .def_property_readonly(
          "node",
          [](const OutputObject& o) {
            return NodeObject{o.graph, o.node};
          },
          "The Node.")
      .def_readonly("port", &OutputObject::port, "Name of the output.")
      .def_readonly("type", &OutputObject::type, "Name of the value's type.")
      .def_property_readonly("reference", &OutputObject::text, "NODE.PORT, as in graph files.")
      .def(
          "value",
          [](const OutputObject& o) {
            if (const Value v = graph_of(o.graph).known(o.text())) return to_python(v);
            return py::object(o.graph.attr("_evaluate")(o.text()));
          },
          "The value. Evaluates what is not cached; Ctrl-C stops that. Raises Error if a node fails. A "
          "repeated node gives a list, as values() does.")
      .def(
          "values",
          [](const py::object& self) {
            const py::object v = self.attr("value")();
            return PyList_Check(v.ptr()) ? v.cast<py::list>() : py::list(py::make_tuple(v));
          },
          "The values of a repeated node's elements, in order, as a list. Any other node gives a list of "
          "one.")
      .def("__repr__",
           [](const OutputObject& o) { return fmt::format("<Output {}: {}>", o.text(), o.type); });
}

// Items, attributes and text, as Python wants them.
void bind_node_protocol(py::class_<NodeObject>& c) {
  c.def("__setitem__",
        [](const NodeObject& n, const std::string& p, const py::object& value) {
          graph_of(n.graph).set(n.name, {{{p, plain(value)}}, callers_place()});
        })
      .def("__getattr__",
           [](const NodeObject& n, const std::string& port) {
             if (port.rfind("__", 0) == 0 || port.rfind("_repr", 0) == 0 || port.rfind("_ipython", 0) == 0)
               throw py::attribute_error(port);
             return output(n, port);
           })
      .def("__setattr__",
           [](const NodeObject&, const std::string& name, const py::object&) {
             throw py::attribute_error(fmt::format(
                 "'{}' cannot be assigned; set a parameter with node['{}'] = …, or connect an input "
                 "with node.set({}=…)",
                 name, name, name));
           })
      .def("__dir__",
           [](const py::object& self) {
             const auto& n = self.cast<const NodeObject&>();
             py::list names = py::module_::import("builtins").attr("object").attr("__dir__")(self);
             for (const auto& p : graph_of(n.graph).type_of(n.name).outputs) names.append(p.name);
             return names;
           })
      .def("__eq__",
           [](const NodeObject& a, const py::object& b) {
             return py::isinstance<NodeObject>(b) && a.name == b.cast<const NodeObject&>().name &&
                    a.graph.is(b.cast<const NodeObject&>().graph);
           })
      .def("__hash__", [](const NodeObject& n) { return py::hash(py::str(n.name)); })
      .def("__repr__", [](const NodeObject& n) {
        return fmt::format("<{} '{}'>", graph_of(n.graph).type_of(n.name).name, n.name);
      });
}

void bind_nodes(py::module_& m) {
  using py::arg;
  py::class_<NodeObject> c(
      m, "Node",
      "A node of a graph. Its outputs are attributes; its parameters are items: node['seed'] = 2.");
  c.def_readonly("graph", &NodeObject::graph, "The Graph.")
      .def_readonly("name", &NodeObject::name, "Name in the graph.")
      .def_property_readonly(
          "type", [](const NodeObject& n) { return graph_of(n.graph).type_of(n.name).name; },
          "Name of the node's type.")
      .def("output", output, arg("name"), "An output by name.")
      .def_property_readonly(
          "each",
          [](const NodeObject& n) {
            py::dict out;
            for (const auto& [name, v] : graph_of(n.graph).each(n.name))
              out[py::str(name)] = v.is_list ? py::object(py::cast(v.items)) : py::object(py::str(v.text()));
            return out;
          },
          "What the node is repeated for: lists or ranges by name. Empty for other nodes.")
      .def_property_readonly(
          "outputs",
          [](const NodeObject& n) {
            std::vector<std::string> names;
            for (const auto& p : graph_of(n.graph).type_of(n.name).outputs) names.push_back(p.name);
            return names;
          },
          "Names of the outputs.")
      .def(
          "set",
          [](const NodeObject& n, const py::kwargs& values) {
            graph_of(n.graph).set(n.name, edit_of(values));
          },
          "Changes parameters and inputs, all or none: node.set(seed=2, image=other.image). None restores a "
          "parameter's default and disconnects an input.")
      .def(
          "__getitem__",
          [](const NodeObject& n, const std::string& p) { return graph_of(n.graph).parameter(n.name, p); },
          "The value of a parameter.");
  bind_node_protocol(c);
}

// Opening, nodes and ports.
void bind_nodes_of_graph(py::class_<GraphObject>& c) {
  c.def("_open", [](GraphObject& g, const std::string& file) { g.open(file); })
      .def("_open_text",
           [](GraphObject& g, const std::string& text, const std::string& file) { g.open_text(text, file); })
      .def("_add",
           [](const py::object& self, const std::string& type, py::dict values) {
             const std::string name = take_name(values);
             return NodeObject{self, graph_of(self).add(type, name, edit_of(values))};
           })
      .def("_add_subgraph",
           [](const py::object& self, const std::string& file, py::dict values) {
             const std::string name = take_name(values);
             return NodeObject{self, graph_of(self).add_subgraph(file, name, edit_of(values))};
           })
      .def("_node",
           [](const py::object& self, const std::string& name) {
             graph_of(self).type_of(name);
             return NodeObject{self, name};
           })
      .def("_output_at", output_at)
      .def("_remove", &GraphObject::remove)
      .def("_rename", &GraphObject::rename)
      .def("_names",
           [](const GraphObject& g) {
             std::vector<std::string> out;
             for (const auto& n : g.document().nodes) out.push_back(n.name);
             return out;
           })
      .def("_ports", [](const GraphObject& g, bool outputs) {
        std::vector<std::pair<std::string, std::string>> out;
        for (const auto& [name, w] : outputs ? g.document().outputs : g.document().inputs)
          out.emplace_back(name, w.text);
        return out;
      });
}

// Parameters, name and links.
void bind_parameters_of_graph(py::class_<GraphObject>& c) {
  c.def("_set_port",
        [](GraphObject& g, bool is_output, const std::string& name, const std::string& reference) {
          g.set_port(is_output, name, reference, callers_place());
        })
      .def("_parameters", parameters)
      .def("_add_parameter", add_parameter)
      .def("_parameter_reference",
           [](const py::object& self, const std::string& name) {
             return ParameterReference{self, name};
           })
      .def("_set_parameter",
           [](GraphObject& g, const std::string& name, const py::object& value) {
             g.set_parameter(name, plain(value), callers_place());
           })
      .def("_name", [](const GraphObject& g) { return py::make_tuple(g.document().name, g.document().doc); })
      .def("_set_name", &GraphObject::set_name)
      .def("_file", [](const GraphObject& g) { return g.opened().string(); })
      .def("_written_parameter", &GraphObject::written_parameter)
      .def("_link", [](GraphObject& g) {
        py::list out;
        for (const auto& d : g.link()) out.append(to_python(d));
        return out;
      });
}

// What a graph writes.
void bind_texts_of_graph(py::class_<GraphObject>& c) {
  c.def("_text", [](GraphObject& g, const std::string& folder,
                    bool flat) { return flat ? g.flat_text(folder) : g.text(folder); })
      .def("_given_value",
           [](const GraphObject& g, const std::string& node) { return to_python(g.given_value(node)); })
      .def("_save",
           [](const GraphObject& g, const std::string& file, bool flat,
              const std::map<std::string, std::tuple<std::string, std::string,
                                                     std::map<std::string, py::object>>>& stand_ins) {
             GraphObject::StandIns with;
             for (const auto& [node, s] : stand_ins)
               with[node] = {std::get<0>(s), std::get<1>(s), std::get<2>(s)};
             const fs::path folder = fs::absolute(file).parent_path();
             g.require_other_file(file);
             write_text_atomically(file, flat ? g.flat_text(folder, with) : g.text(folder, with));
           })
      .def("_require_other_file",
           [](const GraphObject& g, const std::string& file) { g.require_other_file(file); })
      .def("_explain", explain)
      .def("_draw", draw)
      .def("_revision", &GraphObject::revision)
      .def("_write_trouble", [](GraphObject& g) { return g.session().evaluator().store().trouble(); })
      .def("_written", [](GraphObject& g) { return g.session().evaluator().store().written(); });
}

}  // namespace

void bind_graph(py::module_& m) {
  using py::arg;
  bind_outputs(m);
  bind_nodes(m);
  py::class_<GraphObject> c(m, "Graph", py::dynamic_attr());
  c.def(py::init([](const std::string& cache, std::uint64_t memory, std::uint64_t file_memory, int threads) {
          SessionOptions o;
          o.cache_folder = cache;
          o.file_memory = file_memory;
          o.threads = threads;
          if (memory > 0) o.memory = memory;
          return std::make_unique<GraphObject>(o, callers_place().file);
        }),
        arg("cache"), arg("memory"), arg("file_memory"), arg("threads"));
  bind_nodes_of_graph(c);
  bind_parameters_of_graph(c);
  bind_texts_of_graph(c);
}

}  // namespace terrazzo::python
