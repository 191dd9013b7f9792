// Python objects as written values of parameters.
#include <fmt/format.h>

#include <algorithm>

#include "graph/nearest.h"
#include "runtime/python/edits.h"
#include "runtime/python/graph_object.h"

namespace terrazzo::python {
namespace fs = std::filesystem;

bool is_reference(const std::string& text) { return text.find("${") != std::string::npos; }

void make_absolute(const Parameter& p, WrittenValue& v) {
  if (p.kind != ParameterKind::InputPath || v.is_list || v.items.empty()) return;
  std::string& path = v.items[0];
  if (path.empty() || path.rfind("${", 0) == 0) return;
  if (std::find(p.keywords.begin(), p.keywords.end(), path) != p.keywords.end()) return;
  if (path[0] == '~' && (path.size() == 1 || path[1] == '/'))
    throw Error("bad-value", fmt::format("'{}' starts with ~, which is not expanded", path),
                "use os.path.expanduser");
  path = fs::absolute(path).lexically_normal().string();
}

WrittenValue written_values(const py::handle& h) {
  if (!PyRange_Check(h.ptr())) return written_value(h);
  const auto at = [&](const char* name) { return h.attr(name).cast<std::int64_t>(); };
  const auto count = static_cast<std::int64_t>(py::len(h));
  if (count == 0) throw Error("bad-value", "the range is empty");
  const std::int64_t first = at("start"), step = at("step");
  return {false, {fmt::format("{}:{}:{}", first, first + (count - 1) * step, step)}, {}};
}

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

void check_name(const std::string& name) {
  if (name.empty() || name.find_first_of(". /\n") != std::string::npos)
    throw Error(
        "bad-name",
        fmt::format("'{}' is not a valid name: it must not be empty or contain dots, slashes or spaces",
                    name));
}

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

}  // namespace terrazzo::python
