// Shared by the files of the extension `terrazzo._core`.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>

#include "graph/registry.h"
#include "runtime/value.h"

namespace terrazzo::python {

namespace py = pybind11;

// The node and value types of this process: the built-in ones, plugins, and those written in Python. Only
// used with the GIL held.
Registry& registry();
const ValueTypes& value_types();

// Each adds its part to the module.
void bind_errors(py::module_&);
void bind_values(py::module_&);
void bind_volumes(py::module_&);
void bind_arrays(py::module_&);
void bind_volume_arrays(py::module_&);
void bind_graph(py::module_&);
void bind_runs(py::module_&);
void bind_python_nodes(py::module_&);
void bind_cache(py::module_&);
void bind_reproduce(py::module_&);

// Raises terrazzo.Error with these messages. The first error is the exception itself. `cause`: the exception
// that led to it, or None.
[[noreturn]] void raise(const Diagnostics&, const py::object& cause = py::none());
// A message as terrazzo.Diagnostic.
py::object to_python(const Diagnostic&);

// The object that stands for a value, of the class of its type.
py::object to_python(const Value&);
// The value of such an object. Throws Error "wrong-type" if the object is none.
const Value& to_value(const py::handle&);
bool is_value(const py::handle&);

// The text of a Python string. Throws Error "bad-value" if UTF-8 cannot represent it, as in names of files
// that are not UTF-8.
std::string utf8(const py::handle&);

// JSON text as Python objects.
py::object from_json(const std::string&);

// The place in the user's script of the call being made: the innermost frame outside of this package.
Place callers_place();

// The value with paths, numbers of numpy and sequences as plain text, numbers and lists. It runs the code of
// the user's classes, which may edit graphs and let other threads run, so call it before an edit begins.
// `depth`: of lists in lists.
py::object plain(const py::object&, int depth = 2);

// A Python object as the written value of a parameter. Throws Error "bad-value" for objects of other kinds.
WrittenValue written_value(const py::handle&);

}  // namespace terrazzo::python
