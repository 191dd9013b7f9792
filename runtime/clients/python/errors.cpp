// Messages and exceptions.
#include <exception>

#include "runtime/clients/python/bind.h"

namespace terrazzo::python {
namespace {

const char* name_of(Severity s) {
  return s == Severity::Error ? "error" : s == Severity::Warning ? "warning" : "note";
}

py::handle error_class() {
  static const py::handle c =
      py::module_::import("terrazzo._errors").attr("Error").cast<py::object>().release();
  return c;
}

}  // namespace

py::object to_python(const Diagnostic& d) {
  static const py::handle c =
      py::module_::import("terrazzo._errors").attr("Diagnostic").cast<py::object>().release();
  py::list through;
  for (const auto& p : d.through) through.append(py::make_tuple(p.file, p.line, p.column));
  return c(name_of(d.severity), d.code, d.message, d.hint, d.node, d.parameter, d.item, d.place.file,
           d.place.line, d.place.column, through, d.text());
}

void raise(const Diagnostics& all, const py::object& cause) {
  py::list list;
  for (const auto& d : all)
    if (d.severity == Severity::Error) list.append(to_python(d));
  const py::object error = error_class()(list);
  if (!cause.is_none()) PyException_SetCause(error.ptr(), cause.inc_ref().ptr());
  PyErr_SetObject(error_class().ptr(), error.ptr());
  throw py::error_already_set();
}

void bind_errors(py::module_& m) {
  m.def("raise_error", [](const std::string& code, const std::string& message, const std::string& hint,
                          const std::string& node, const std::string& parameter) {
    Diagnostic d{Severity::Error, code, message, hint, callers_place(), node, parameter};
    raise({d});
  });
  py::register_local_exception_translator([](std::exception_ptr p) {
    try {
      if (p) std::rethrow_exception(p);
    } catch (const Error& e) {
      Diagnostic d = e.diagnostic();
      if (d.place.file.empty()) d.place = callers_place();
      py::list list;
      list.append(to_python(d));
      PyErr_SetObject(error_class().ptr(), py::object(error_class()(list)).ptr());
    } catch (const Cancelled&) {
      const py::object c = py::module_::import("terrazzo._errors").attr("Canceled");
      PyErr_SetObject(c.ptr(), py::object(c()).ptr());
    }
  });
}

std::string utf8(const py::handle& text) {
  Py_ssize_t size = 0;
  const char* data = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (data) return {data, static_cast<std::size_t>(size)};
  PyErr_Clear();
  const auto shown = py::reinterpret_steal<py::object>(PyObject_ASCII(text.ptr()));
  throw Error("bad-value", (shown ? utf8(shown) : "a string") + " is not UTF-8",
              "rename files whose names are not UTF-8");
}

Place callers_place() {
  // Borrowed references, except for the frames and the code.
  Place out;
  PyFrameObject* frame = PyEval_GetFrame();
  Py_XINCREF(frame);
  static const std::string package = [] {
    const auto file = py::module_::import("terrazzo").attr("__file__").cast<std::string>();
    return file.substr(0, file.rfind('/') + 1);
  }();
  while (frame) {
    PyCodeObject* code = PyFrame_GetCode(frame);
    Py_ssize_t size = 0;
    const char* file = PyUnicode_AsUTF8AndSize(code->co_filename, &size);
    if (!file) PyErr_Clear();
    const bool outside =
        file && std::string_view(file, static_cast<std::size_t>(size)).rfind(package, 0) != 0;
    if (outside) out = {file, PyFrame_GetLineNumber(frame), 0};
    Py_DECREF(code);
    PyFrameObject* back = outside ? nullptr : PyFrame_GetBack(frame);
    Py_DECREF(frame);
    frame = back;
  }
  return out;
}

}  // namespace terrazzo::python
