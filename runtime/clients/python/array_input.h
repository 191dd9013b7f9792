// What the user's arrays have in common: each is checked and copied, so later changes to it change nothing.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "runtime/clients/python/outside.h"
#include "runtime/clients/python/value_views.h"
#include "runtime/memory.h"

namespace terrazzo::python {

inline Shape_ shape_of(const py::array& a) { return {a.shape(), a.shape() + a.ndim()}; }

inline std::string text_of(const py::array& a) {
  return fmt::format("{} ({})", py::str(a.dtype()).cast<std::string>(), fmt::join(shape_of(a), ", "));
}

inline py::array array_of(const py::object& object, const char* what) {
  if (py::hasattr(object, "mask") && py::hasattr(object, "filled") && py::hasattr(object, "dtype"))
    throw Error("wrong-type", fmt::format("{} is a masked array, and a value has no mask", what),
                "replace the masked elements: array.filled(0)");
  py::array a = py::array::ensure(object);
  if (!a) {
    PyErr_Clear();
    throw Error("wrong-type", fmt::format("{} is not an array", what), "pass a numpy array");
  }
  return a;
}

inline bool is_whole(const py::array& a) {
  const char kind = a.dtype().kind();
  return kind == 'i' || kind == 'u' || kind == 'b';
}

// The array as T in C order. A copy only if it is not that already.
template <class T>
py::array_t<T, py::array::c_style | py::array::forcecast> numbers(const py::array& a, const char* what) {
  if (!is_whole(a) && a.dtype().kind() != 'f')
    throw Error("wrong-type", fmt::format("{} must be an array of real numbers, not {}", what, text_of(a)));
  require_memory(static_cast<double>(a.size()) * sizeof(T), available_memory(),
                 fmt::format("a copy of {}", what));
  py::array_t<T, py::array::c_style | py::array::forcecast> out(a);
  return out;
}

// Lengths as parameters of nodes take them.
inline constexpr double kSmallestLength = 1e-9;
inline constexpr double kLargestLength = 1e9;  // mm

inline void require_length(double v, const char* name) {
  if (!(v >= kSmallestLength && v <= kLargestLength))
    throw Error("bad-value", fmt::format("{} must be from {} to {} mm; it is {}", name, kSmallestLength,
                                         kLargestLength, v))
        .parameter(name);
}

}  // namespace terrazzo::python
