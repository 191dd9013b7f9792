// Values as objects whose arrays are views: read-only, without a copy, keeping the value alive.
#pragma once

#include <utility>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/clients/python/value_object.h"

namespace terrazzo::python {

using Shape_ = std::vector<py::ssize_t>;  // of arrays; `Shape` is a particle's

// An array that shows memory of a value. `owner` is the object of the value.
inline py::array view(const py::handle& owner, const py::dtype& type, const void* data, Shape_ shape,
                      Shape_ strides) {
  py::array a(type, std::move(shape), std::move(strides), data, owner);
  py::detail::array_proxy(a.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return a;
}

template <class T>
py::array view(const py::handle& owner, const T* data, Shape_ shape) {
  Shape_ strides(shape.size());
  py::ssize_t step = sizeof(T);
  for (std::size_t i = shape.size(); i-- > 0;) {
    strides[i] = step;
    step *= shape[i];
  }
  return view(owner, py::dtype::of<T>(), data, std::move(shape), std::move(strides));
}

template <class T>
py::array view(const py::handle& owner, const std::vector<T>& v) {
  return view(owner, v.data(), {static_cast<py::ssize_t>(v.size())});
}

// Vectors as the rows of an array.
template <class V>
py::array rows(const py::handle& owner, const std::vector<V>& v) {
  using S = typename V::Scalar;
  constexpr py::ssize_t kN = sizeof(V) / sizeof(S);
  return view(owner, reinterpret_cast<const S*>(v.data()), {static_cast<py::ssize_t>(v.size()), kN});
}

// One member of every element of a list of structures.
template <class S, class Item>
py::array member(const py::handle& owner, const std::vector<Item>& list, const void* of_first,
                 int width = 1) {
  Shape_ shape{static_cast<py::ssize_t>(list.size())}, strides{sizeof(Item)};
  if (width > 1) {
    shape.push_back(width);
    strides.push_back(sizeof(S));
  }
  return view(owner, py::dtype::of<S>(), of_first, std::move(shape), std::move(strides));
}

template <class T>
const T& the(const py::object& self) {
  return self.cast<const ValueObject&>().value.as<T>();
}

inline py::array_t<float> color(const Vec3f& c) { return py::array_t<float>(3, c.data()); }

template <class V>
py::tuple tuple_of(const V& v) {
  py::tuple out(v.size());
  for (Eigen::Index i = 0; i < v.size(); ++i) out[static_cast<std::size_t>(i)] = v[i];
  return out;
}

// The object of a value of one type, so that each has a class in Python.
template <class T>
struct ObjectOf : ValueObject {
  using ValueObject::ValueObject;
};

template <class Part, class List>
py::list parts(const py::object& self, const List& list) {
  py::list out;
  for (const auto& item : list) out.append(Part{self, &item});
  return out;
}

// Each adds the classes of its file.
void bind_pictures(py::module_&);
void bind_profiles(py::module_&);
void bind_sizes(py::module_&);
void bind_tables(py::module_&);
void bind_kmatrix(py::module_&);
void bind_shapes(py::module_&);
void bind_particles(py::module_&);
void bind_strokes(py::module_&);

}  // namespace terrazzo::python
