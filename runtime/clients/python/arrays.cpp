// Arrays of the user as values. Every array is checked and copied, so later changes to it change nothing.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/table.h"
#include "nodes/sizes/distribution/size_laws.h"
#include "runtime/clients/python/array_input.h"
#include "runtime/memory.h"

namespace terrazzo::python {
namespace {

struct Extent {
  int width, height, sections;
};

// `color`: the last axis is the color.
Extent extent_of(const py::array& a, bool color, const char* what) {
  const Shape_ shape = shape_of(a);
  const std::size_t n = shape.size() - (color ? 1 : 0);
  const py::ssize_t sections = n == 3 ? shape[0] : 1;
  const py::ssize_t height = shape[n - 2];
  const py::ssize_t width = shape[n - 1];
  if (sections < 1 || height < 1 || width < 1)
    throw Error("empty-image", fmt::format("{} is empty: {}", what, text_of(a)));
  constexpr py::ssize_t kMost = std::numeric_limits<int>::max();
  if (sections > kMost || height > kMost || width > kMost ||
      static_cast<double>(sections) * height * width > 4e9)
    throw Error("too-large", fmt::format("{} has more than 4·10⁹ pixels: {}", what, text_of(a)));
  return {static_cast<int>(width), static_cast<int>(height), static_cast<int>(sections)};
}

py::object image(const py::object& object, double pixel_size, bool srgb) {
  const py::array a = array_of(object, "the image");
  const Shape_ shape = shape_of(a);
  const bool color = (shape.size() == 3 || shape.size() == 4) && (shape.back() == 3 || shape.back() == 4);
  if (!color && shape.size() != 2)
    throw Error(
        "wrong-shape",
        fmt::format("an image has the shape (height, width), (height, width, 3) or (sections, height, "
                    "width, 3), not {}",
                    text_of(a)),
        "for a stack of gray sections, repeat the values along a last axis of 3");
  require_length(pixel_size, "pixel_size");
  const Extent e = extent_of(a, color, "the image");
  // Whole numbers are scaled by their largest value, as image files store them.
  double scale = 1;
  if (is_whole(a)) {
    const auto bytes = a.itemsize();
    if (a.dtype().kind() == 'b')
      scale = 1;
    else if (a.dtype().kind() == 'u' && bytes <= 2)
      scale = bytes == 1 ? 1 / 255.0 : 1 / 65535.0;
    else
      throw Error("wrong-type", fmt::format("an image of {} has no defined white", text_of(a)),
                  "use uint8, uint16 or floats from 0 to 1");
  }
  const auto data = numbers<float>(a, "the image");
  const float* in = data.data();
  const int channels = color ? static_cast<int>(shape.back()) : 1;
  const std::size_t n = static_cast<std::size_t>(e.width) * e.height * e.sections;
  require_memory(static_cast<double>(n) * 12, available_memory(), "the image");
  Image out(e.width, e.height, e.sections, pixel_size);
  {
    const Outside outside;
    for (std::size_t i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c) {
        double v = in[i * channels + (color ? c : 0)] * scale;
        if (!std::isfinite(v))
          throw Error(
              "bad-pixels",
              fmt::format("the pixel ({}, {}) of the image is {}", i % e.width, i / e.width % e.height, v),
              "replace NaN and infinite values");
        if (srgb) v = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
        out.pixels[i][c] = v;
      }
  }
  return to_python(Value::of(std::move(out)));
}

namespace {

// Numbers the labels of one section by increasing value, after `last`. Returns the last number.
std::int64_t number_labels(const std::vector<std::int64_t>& pixels, bool is_unsigned, std::int64_t last,
                           std::int32_t* ids) {
  std::vector<std::int64_t> values = pixels;
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.front() < 0 && is_unsigned)
    throw Error("bad-labels", fmt::format("a label is {}; the largest possible label is 2⁶³ − 1",
                                          static_cast<std::uint64_t>(values.front())));
  if (values.front() < 0)
    throw Error("bad-labels",
                fmt::format("a label is {}; 0 is binder, and particles are numbered from 1", values.front()));
  if (values.front() == 0) values.erase(values.begin());
  if (last + static_cast<std::int64_t>(values.size()) > std::numeric_limits<std::int32_t>::max())
    throw Error("too-large", "the array has more than 2³¹ − 1 different labels");
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i] != 0)
      ids[i] = last + 1 + (std::lower_bound(values.begin(), values.end(), pixels[i]) - values.begin());
  return last + static_cast<std::int64_t>(values.size());
}

void read_classes(const py::object& classes, std::vector<int>& out) {
  const std::int64_t last = out.size();
  const py::array c = array_of(classes, "classes");
  if (!is_whole(c) || c.ndim() != 1 || c.size() != last)
    throw Error("wrong-shape",
                fmt::format("classes must be {} whole numbers, one for each label, not {}", last, text_of(c)),
                "order them by section, then by increasing label");
  const auto list = numbers<std::int64_t>(c, "classes");
  for (std::int64_t i = 0; i < last; ++i) {
    const std::int64_t v = list.data()[i];
    if (v < 0 && c.dtype().kind() == 'u')
      throw Error("bad-labels",
                  fmt::format("class {} is not in 0 to 1,000,000", static_cast<std::uint64_t>(v)));
    if (v < 0 || v > 1'000'000)
      throw Error("bad-labels", fmt::format("class {} is not in 0 to 1,000,000", v));
    out[i] = v;
  }
}

}  // namespace

py::object labels(const py::object& object, double pixel_size, const py::object& classes) {
  const py::array a = array_of(object, "the labels");
  if (a.ndim() != 2 && a.ndim() != 3)
    throw Error("wrong-shape",
                fmt::format("labels have the shape (height, width) or (sections, height, width), not {}",
                            text_of(a)));
  if (!is_whole(a))
    throw Error("wrong-type", fmt::format("labels are whole numbers, not {}", text_of(a)),
                "convert them with .astype('int32')");
  require_length(pixel_size, "pixel_size");
  const Extent e = extent_of(a, false, "the array of labels");
  const auto data = numbers<std::int64_t>(a, "the labels");  // uint64 beyond int64 becomes negative
  const std::int64_t* in = data.data();
  const std::size_t n = data.size(), plane = static_cast<std::size_t>(e.width) * e.height;
  Labels out;
  out.width = e.width;
  out.height = e.height;
  out.sections = e.sections;
  out.pixel_size = pixel_size;
  require_memory(static_cast<double>(n) * 4 + static_cast<double>(plane) * 16, available_memory(),
                 "the labels");
  out.ids.resize(n);
  std::int64_t last = 0;
  const bool is_unsigned = a.dtype().kind() == 'u';
  {
    // As in LoadLabels: profiles are numbered by section, then by increasing value.
    const Outside outside;
    for (int s = 0; s < e.sections; ++s) {
      // A copy, since other threads may write to the array.
      const std::vector<std::int64_t> pixels(in + s * plane, in + (s + 1) * plane);
      last = number_labels(pixels, is_unsigned, last, &out.ids[s * plane]);
    }
  }
  if (last == 0)
    throw Error("no-particles", "every label is 0", "number the pixels of each particle from 1; 0 is binder");
  out.classes.assign(last, 0);
  if (!classes.is_none()) read_classes(classes, out.classes);
  return to_python(Value::of(std::move(out)));
}

Mesh mesh_of(const py::object& vertices, const py::object& triangles) {
  const py::array v = array_of(vertices, "vertices"), t = array_of(triangles, "triangles");
  if (v.ndim() != 2 || v.shape(1) != 3)
    throw Error("wrong-shape", fmt::format("vertices have the shape (n, 3), not {}", text_of(v)));
  if (t.ndim() != 2 || t.shape(1) != 3)
    throw Error("wrong-shape", fmt::format("triangles have the shape (m, 3), not {}", text_of(t)),
                "split larger faces into triangles");
  if (!is_whole(t))
    throw Error("wrong-type", fmt::format("triangles are vertex numbers, not {}", text_of(t)));
  const auto points = numbers<double>(v, "vertices");
  const auto corners = numbers<std::int64_t>(t, "triangles");
  Mesh mesh;
  for (py::ssize_t i = 0; i < v.shape(0); ++i) {
    const Vec3 p(points.at(i, 0), points.at(i, 1), points.at(i, 2));
    if (!(p.array().abs() <= kLargestLength).all())  // also NaN
      throw Error("bad-mesh", fmt::format("vertex {} is ({}, {}, {}), which is not within {} mm", i, p.x(),
                                          p.y(), p.z(), kLargestLength));
    mesh.vertices.push_back(p);
  }
  for (py::ssize_t i = 0; i < t.shape(0); ++i) {
    Triangle corner;
    for (int k = 0; k < 3; ++k) {
      const std::int64_t at = corners.at(i, k);
      if (at < 0 || at >= v.shape(0))
        throw Error("bad-mesh",
                    fmt::format("triangle {} names vertex {}, but there are {}", i, at, v.shape(0)),
                    "vertices are numbered from 0");
      corner[k] = at;
    }
    mesh.triangles.push_back(corner);
  }
  if (mesh.triangles.empty()) throw Error("bad-mesh", "the mesh has no triangles");
  return mesh;
}

py::object mesh(const py::object& vertices, const py::object& triangles, const std::string& name) {
  Mesh m = mesh_of(vertices, triangles);
  Shapes out;
  {
    const Outside outside;
    out.shapes.push_back(measure_shape(name, std::move(m)));
  }
  return to_python(Value::of(std::move(out)));
}

std::vector<double> list_of(const py::object& object, const char* name, double most) {
  const py::array a = array_of(object, name);
  if (a.ndim() != 1)
    throw Error("wrong-shape", fmt::format("{} is a list of numbers, not {}", name, text_of(a)));
  const auto data = numbers<double>(a, name);
  std::vector<double> out(data.data(), data.data() + data.size());
  for (const double v : out)
    if (!(v >= 0 && v <= most))
      throw Error("bad-value", fmt::format("{} must be from 0 to {}; an element is {}", name, most, v))
          .parameter(name);
  return out;
}

py::object sizes(const py::object& class_edges, const py::object& N_V, const py::object& low,
                 const py::object& high) {
  constexpr double kMost = 1e18;  // per mm³, as in Distribution
  distribution::SizeLaw law;
  law.kind = distribution::LawKind::Classes;
  law.class_edges = list_of(class_edges, "class_edges", kLargestLength);
  law.N_V = list_of(N_V, "N_V", kMost);
  if (!low.is_none()) law.low = list_of(low, "low", kMost);
  if (!high.is_none()) law.high = list_of(high, "high", kMost);
  return to_python(Value::of(distribution::make_distribution(law, nullptr)));
}

py::object table(const py::dict& columns) {
  Table out;
  std::vector<py::list> lists;
  for (const auto& [name, cells] : columns) {
    out.columns.push_back(utf8(name));
    lists.push_back(py::reinterpret_borrow<py::list>(cells));
    if (lists.back().size() != lists.front().size())
      throw Error("wrong-count", fmt::format("the columns '{}' and '{}' differ in length",
                                             out.columns.front(), out.columns.back()));
  }
  out.rows.resize(lists.empty() ? 0 : lists.front().size());
  for (const auto& list : lists)
    for (std::size_t i = 0; i < list.size(); ++i) {
      const py::object cell = list[i];
      if (PyUnicode_Check(cell.ptr())) {
        out.rows[i].emplace_back(utf8(cell));
        continue;
      }
      const double v = PyFloat_AsDouble(cell.ptr());
      if (v == -1 && PyErr_Occurred()) {
        PyErr_Clear();
        throw Error("wrong-type",
                    fmt::format("a cell is a {}; cells are numbers or text", Py_TYPE(cell.ptr())->tp_name));
      }
      out.rows[i].emplace_back(v);
    }
  return to_python(Value::of(std::move(out)));
}

}  // namespace

void bind_arrays(py::module_& m) {
  using py::arg;
  m.def("image", image, arg("array"), arg("pixel_size"), arg("srgb"));
  m.def("labels", labels, arg("array"), arg("pixel_size"), arg("classes"));
  m.def("mesh", mesh, arg("vertices"), arg("triangles"), arg("name"));
  m.def("table", table, arg("columns"));
  m.def("sizes", sizes, arg("class_edges"), arg("N_V"), arg("low"), arg("high"));
}

}  // namespace terrazzo::python
