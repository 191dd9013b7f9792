// Python objects as written values of parameters.
#include <fmt/format.h>

#include <algorithm>

#include "graph/text/nearest.h"
#include "runtime/clients/python/edits.h"
#include "runtime/clients/python/graph_object.h"

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
  const std::int64_t count = py::len(h);
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

py::object plain(const py::object& value, int depth) {
  const py::handle h = value;
  if (h.is_none() || PyUnicode_CheckExact(h.ptr()) || PyLong_CheckExact(h.ptr()) ||
      PyFloat_CheckExact(h.ptr()) || PyBool_Check(h.ptr()) || PyRange_Check(h.ptr()) ||
      py::isinstance<OutputObject>(h) || py::isinstance<NodeObject>(h) ||
      py::isinstance<ParameterReference>(h) || is_value(h))
    return value;
  if (PyUnicode_Check(h.ptr())) return py::str(utf8(h));
  if (PyFloat_Check(h.ptr())) return py::float_(PyFloat_AS_DOUBLE(h.ptr()));
  if (PyLong_Check(h.ptr())) return py::reinterpret_steal<py::object>(PyNumber_Long(h.ptr()));
  const auto items = [&](const py::object& list) {
    py::list out;
    for (const auto& item : py::list(list))
      out.append(plain(py::reinterpret_borrow<py::object>(item), depth - 1));
    return out;
  };
  if (PyDict_Check(h.ptr()) && depth > 0) {
    const py::list keys = value.attr("keys")();
    const py::list values = items(value.attr("values")());
    py::dict out;
    for (std::size_t i = 0; i < std::min(keys.size(), values.size()); ++i) out[keys[i]] = values[i];
    return out;
  }
  if (py::isinstance<py::array>(h)) return h.cast<py::array>().ndim() < 2 ? value.attr("tolist")() : value;
  if ((PyList_Check(h.ptr()) || PyTuple_Check(h.ptr())) && depth > 0) return items(value);
  if (py::hasattr(h, "__fspath__")) {
    const py::object path = value.attr("__fspath__")();
    if (PyUnicode_Check(path.ptr())) return py::str(utf8(path));
    throw Error("bad-value", fmt::format("a path must be text, not {}", Py_TYPE(path.ptr())->tp_name));
  }
  if (py::hasattr(h, "dtype") && py::hasattr(h, "item") && py::hasattr(h, "ndim") &&
      value.attr("ndim").cast<int>() == 0)
    return value.attr("item")();  // a number of numpy
  return value;
}

WrittenValue written_value(const py::handle& h) {
  const auto scalar = [](const py::handle& v) -> std::optional<std::string> {
    if (PyBool_Check(v.ptr())) return v.ptr() == Py_True ? "true" : "false";
    if (PyUnicode_Check(v.ptr())) return utf8(v);
    if (PyLong_Check(v.ptr())) return py::str(v).cast<std::string>();
    if (PyFloat_Check(v.ptr())) return fmt::format("{}", v.cast<double>());
    if (py::isinstance<ParameterReference>(v)) return "${" + v.cast<const ParameterReference&>().name + "}";
    return {};
  };
  if (const auto one = scalar(h)) return {false, {*one}, {}};
  if (PyList_Check(h.ptr()) || PyTuple_Check(h.ptr())) {
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
