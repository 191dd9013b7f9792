// Node types whose compute function is written in Python.
#include <fmt/format.h>

#include <map>
#include <mutex>

#include "runtime/clients/python/graph_object.h"
#include "runtime/clients/python/python_node.h"
#include "runtime/clients/python/value_object.h"
#include "runtime/context.h"
#include "runtime/given.h"

namespace terrazzo::python {
namespace {

// The parameter that holds the hash of the function's source. It is part of the key, and finds the function.
constexpr const char* kSource = "source_hash";

constexpr std::size_t kMostExceptions = 20;

struct PythonNode {
  py::object function;
  std::vector<Port> inputs, outputs;
  std::vector<Parameter> parameters;
};

// Used with the GIL held. Never destroyed: graphs may outlive the interpreter's objects.
std::map<std::string, PythonNode>& functions() {
  static auto& all = *new std::map<std::string, PythonNode>;
  return all;
}

// The running calls, so that canceling stops Python code.
struct Call {
  unsigned long thread;
  const Context* context;
  bool stopped = false;
};
std::vector<Call*>& calls() {
  static auto& all = *new std::vector<Call*>;
  return all;
}

// Exceptions of nodes by their tracebacks, until a run takes them as the cause of its error. They keep the
// variables of the functions that they passed, so only a few of runs that nobody asks are kept.
std::map<std::string, py::object>& exceptions() {
  static auto& all = *new std::map<std::string, py::object>;
  return all;
}

thread_local Context* running = nullptr;

py::object argument(const Context& c, const Parameter& p) {
  switch (p.kind) {
    case ParameterKind::Bool:
      return py::bool_(c.boolean(p.name));
    case ParameterKind::Int:
      return py::int_(c.integer(p.name));
    case ParameterKind::Number:
      return py::float_(c.number(p.name));
    case ParameterKind::Ints:
      return py::cast(c.ints(p.name));
    case ParameterKind::Numbers:
      return py::cast(c.numbers(p.name));
    case ParameterKind::Texts:
      return py::cast(c.texts(p.name));
    case ParameterKind::InputPath:
      return py::str(c.files(p.name).at(0).string());
    default:
      return py::str(c.text(p.name));
  }
}

// str(object) for messages: also where that fails, or gives text that UTF-8 cannot represent, such as the
// name of a file that is not UTF-8.
std::string shown(const py::handle& object) {
  const auto text = py::reinterpret_steal<py::object>(PyObject_Str(object.ptr()));
  const auto bytes = py::reinterpret_steal<py::object>(
      text ? PyUnicode_AsEncodedString(text.ptr(), "utf-8", "backslashreplace") : nullptr);
  if (bytes) return bytes.cast<std::string>();
  PyErr_Clear();
  return "its message cannot be shown";
}

[[noreturn]] void rethrow(py::error_already_set& e, const Context& c) {
  if (c.work().cancelled()) throw Cancelled();
  const std::string type = shown(e.type().attr("__name__")), what = shown(e.value());
  std::string text;
  for (const auto& line :
       py::module_::import("traceback").attr("format_exception")(e.type(), e.value(), e.trace()))
    text += shown(line);
  if (exceptions().size() >= kMostExceptions) exceptions().clear();
  PyException_SetTraceback(e.value().ptr(), e.trace().ptr());
  exceptions()[text] = e.value();
  throw Error("python", what.empty() ? type : type + ": " + what, text);
}

void call(Context& c, const PythonNode& node) {
  py::dict arguments;
  for (const auto& port : node.inputs) {
    if (port.many) {
      py::list list;
      for (const auto& v : c.list(port.name)) list.append(to_python(v));
      arguments[port.name.c_str()] = list;
    } else if (c.has(port.name)) {
      arguments[port.name.c_str()] = to_python(c.value(port.name));
    }
  }
  for (const auto& p : node.parameters)
    if (p.name != kSource) arguments[p.name.c_str()] = argument(c, p);
  py::object result;
  Call now{PyThread_get_thread_ident(), &c};
  calls().push_back(&now);
  running = &c;
  try {
    result = node.function(**arguments);
  } catch (py::error_already_set& e) {
    running = nullptr;
    std::erase(calls(), &now);
    rethrow(e, c);
  }
  running = nullptr;
  std::erase(calls(), &now);
  c.work().check();
  const auto give = [&](const Port& port, const py::object& v) {
    if (!is_value(v) || !port.accepts(to_value(v).type().name))
      throw Error("python",
                  fmt::format("the output '{}' must be a {}, not a {}", port.name, port.type_text(),
                              is_value(v) ? to_value(v).type().name : Py_TYPE(v.ptr())->tp_name),
                  "make values of arrays with terrazzo.image, labels, mesh, sizes or table");
    c.output(port.name, to_value(v));
  };
  if (node.outputs.size() == 1 && !PyDict_Check(result.ptr())) return give(node.outputs[0], result);
  if (!PyDict_Check(result.ptr()))
    throw Error("python", "a node with several outputs must return a dictionary of them");
  const py::dict all = result;
  for (const auto& port : node.outputs) {
    if (!all.contains(port.name.c_str()))
      throw Error("python", fmt::format("the returned dictionary has no output '{}'", port.name));
    give(port, all[port.name.c_str()]);
  }
}

void compute(Context& c) {
  const std::string source = c.text(kSource);
  // Nothing that refers to Python objects may outlive the GIL, exceptions included.
  const py::gil_scoped_acquire gil;
  const auto it = functions().find(source);
  if (it == functions().end())
    throw Error("no-function", "the function of this node is not defined in this process",
                "run the code with @terrazzo.node before the graph");
  const PythonNode node = it->second;
  try {
    call(c, node);
  } catch (py::error_already_set& e) {
    rethrow(e, c);
  }
}

Port port_of(const py::handle& h) {
  Port p;
  p.name = h["name"].cast<std::string>();
  p.doc = utf8(h["doc"]);
  p.types = {h["type"].cast<std::string>()};
  if (h.contains("optional")) p.optional = h["optional"].cast<bool>();
  if (h.contains("many")) p.many = h["many"].cast<bool>();
  return p;
}

Parameter parameter_of(const py::handle& h) {
  Parameter p;
  const auto kind = h["kind"].cast<std::string>();
  bool known = false;
  for (const auto k : {ParameterKind::Bool, ParameterKind::Int, ParameterKind::Number, ParameterKind::Choice,
                       ParameterKind::Text, ParameterKind::Ints, ParameterKind::Numbers, ParameterKind::Texts,
                       ParameterKind::InputPath})
    if (name_of(k) == kind) {
      p.kind = k;
      known = true;
    }
  if (!known) throw Error("bad-node-type", "a parameter cannot have the kind " + kind);
  p.name = h["name"].cast<std::string>();
  p.doc = utf8(h["doc"]);
  p.unit = utf8(h["unit"]);
  p.choices = h["choices"].cast<std::vector<std::string>>();
  if (!h["min"].is_none()) p.min = h["min"].cast<double>();
  if (!h["max"].is_none()) p.max = h["max"].cast<double>();
  if (!h["default"].is_none()) {
    const WrittenValue written = written_value(plain(h["default"].cast<py::object>()));
    std::string why;
    p.value = read_parameter(p, written, why);
    if (!p.value)
      throw Error("bad-node-type", fmt::format("the default of '{}' is invalid: {}", p.name, why));
  }
  return p;
}

void define(const std::string& name, int version, const std::string& doc, const py::list& inputs,
            const py::list& outputs, const py::list& parameters, const std::string& source,
            const py::object& function) {
  if (const NodeType* known = registry().find(name); known && !known->find_parameter(kSource))
    throw Error("duplicate-node-type", fmt::format("terrazzo has a node type {} already", name),
                "rename the function, or pass name=…");
  PythonNode node{function, {}, {}, {}};
  NodeType type(name, version);
  type.doc_(doc).compute_(compute);
  for (const auto& h : inputs) node.inputs.push_back(port_of(h));
  for (const auto& h : outputs) node.outputs.push_back(port_of(h));
  for (const auto& h : parameters) node.parameters.push_back(parameter_of(h));
  type.inputs = node.inputs;
  type.outputs = node.outputs;
  type.parameters = node.parameters;
  type.parameter(Parameter::text(kSource, source).doc_("Hash of the function's source. Set by Python."));
  registry().replace(std::move(type));
  functions()[source] = std::move(node);
}

}  // namespace

void stop_canceled_calls() {
  for (Call* c : calls())
    if (!c->stopped && c->context->work().cancelled()) {
      c->stopped = true;
      const py::object canceled = py::module_::import("terrazzo._errors").attr("Canceled");
      PyThreadState_SetAsyncExc(c->thread, canceled.ptr());
    }
}

py::object take_exception(const std::string& traceback) {
  auto node = exceptions().extract(traceback);
  return node.empty() ? py::none() : std::move(node.mapped());
}

void bind_python_nodes(py::module_& m) {
  register_given_types(registry(), value_types());
  m.def("define_node", define);
  m.def("hash_text", [](const std::string& text) { return hash_of(text).text(); });
  const auto in_node = [](const char* what) -> Context& {
    if (!running)
      throw Error("usage", fmt::format("terrazzo.{} works only inside of a node written in Python", what));
    return *running;
  };
  using py::arg;
  m.def(
      "metric",
      [in_node](const py::object& name, double value) {
        in_node("metric").metric(utf8(py::str(name)), value);
      },
      arg("name"), arg("value"),
      "Reports a number of the running node, which was written in Python: run.metrics[NODE][name].");
  m.def(
      "warn", [in_node](const py::object& message) { in_node("warn").warn(shown(message)); }, arg("message"),
      "Reports a problem of the running node that does not invalidate its result: a NodeWarning.");
  m.def(
      "progress",
      [in_node](double fraction, const py::object& note) {
        if (!(fraction >= 0 && fraction <= 1))
          throw Error("bad-value", fmt::format("progress is from 0 to 1, not {}", fraction));
        // The observer may wait for another thread, which may wait for the GIL.
        Context& c = in_node("progress");
        const std::string text = shown(note);
        const py::gil_scoped_release without_gil;
        c.work().progress(fraction, text);
        c.work().check();
      },
      arg("fraction"), arg("note") = "",
      "Reports how much of the running node's work is done, from 0 to 1. note: what it does now, in a few "
      "words.");
}

}  // namespace terrazzo::python
