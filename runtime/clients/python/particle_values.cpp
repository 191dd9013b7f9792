// Shapes and particles.
#include <fmt/format.h>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/clients/python/value_views.h"

namespace terrazzo::python {
namespace {

struct ShapePart {
  py::object owner;
  const Shape* shape;
};
struct MeshPart {
  py::object owner;
  const Mesh* mesh;
};

}  // namespace

void bind_shapes(py::module_& m) {
  py::class_<MeshPart>(m, "Mesh", "A closed triangle mesh.")
      .def_property_readonly(
          "vertices", [](const MeshPart& p) { return rows(p.owner, p.mesh->vertices); },
          "float64 (n, 3): mm. A view.")
      .def_property_readonly(
          "triangles",
          [](const MeshPart& p) {
            return view(p.owner, reinterpret_cast<const std::int32_t*>(p.mesh->triangles.data()),
                        {static_cast<py::ssize_t>(p.mesh->triangles.size()), 3});
          },
          "int32 (m, 3): vertex numbers, counterclockwise seen from outside. A view.");
  py::class_<ShapePart>(m, "Shape", "A particle shape with its measures at scale 1.")
      .def_property_readonly(
          "name", [](const ShapePart& p) { return p.shape->name; }, "Name.")
      .def_property_readonly(
          "probability", [](const ShapePart& p) { return p.shape->probability; },
          "Probability by number; those of a set sum to 1.")
      .def_property_readonly(
          "cls", [](const ShapePart& p) { return p.shape->cls; },
          "Color or particle class whose particles have this shape; −1: any.")
      .def_property_readonly(
          "mesh",
          [](const ShapePart& p) {
            return MeshPart{p.owner, &p.shape->mesh};
          },
          "The Mesh, with its centroid at the origin.")
      .def_property_readonly(
          "color", [](const ShapePart& p) { return rows(p.owner, p.shape->color); },
          "float32 (n, 3): scene-linear color of each vertex, or no rows. A view.")
      .def_property_readonly(
          "uv",
          [](const ShapePart& p) {
            return view(p.owner, reinterpret_cast<const float*>(p.shape->uv.data()),
                        {static_cast<py::ssize_t>(p.shape->uv.size()), 3, 2});
          },
          "float32 (m, 3, 2): texture coordinates of each triangle's corners from the upper left corner, or "
          "no rows. A view.")
      .def_property_readonly(
          "volume", [](const ShapePart& p) { return p.shape->volume; }, "mm³.")
      .def_property_readonly(
          "surface_area", [](const ShapePart& p) { return p.shape->surface_area; }, "mm².")
      .def_property_readonly(
          "mean_caliper", [](const ShapePart& p) { return p.shape->mean_caliper; },
          "Mean caliper diameter in mm.")
      .def_property_readonly(
          "max_section_area", [](const ShapePart& p) { return p.shape->max_section_area; },
          "Area of the largest plane section in mm².")
      .def_property_readonly(
          "size", [](const ShapePart& p) { return p.shape->size(); }, "√(4·A_max/π) in mm.");
  py::class_<ObjectOf<Shapes>, ValueObject>(m, "Shapes", "Particle shapes with probabilities.")
      .def("__len__", [](const py::object& s) { return the<Shapes>(s).shapes.size(); })
      .def("__getitem__", [](const py::object& s, py::ssize_t i) {
        const auto& v = the<Shapes>(s).shapes;
        const py::ssize_t n = v.size();
        if (i < -n || i >= n) throw py::index_error(fmt::format("there is no shape {} of {}", i, n));
        return ShapePart{s, &v[i < 0 ? i + n : i]};
      });
}

void bind_particles(py::module_& m) {
  py::class_<ObjectOf<Particles>, ValueObject>(
      m, "Particles", "Instances of shapes in a periodic box. Arrays have a row for each particle.")
      .def("__len__", [](const py::object& s) { return the<Particles>(s).count(); })
      .def_property_readonly(
          "box", [](const py::object& s) { return tuple_of(the<Particles>(s).box); },
          "Edges of the box in mm.")
      .def_property_readonly(
          "shape", [](const py::object& s) { return view(s, the<Particles>(s).shape); },
          "int32 (n): number of the shape. A view.")
      .def_property_readonly(
          "cls", [](const py::object& s) { return view(s, the<Particles>(s).cls); },
          "int32 (n): color or particle class. A view.")
      .def_property_readonly(
          "position", [](const py::object& s) { return rows(s, the<Particles>(s).position); },
          "float64 (n, 3): mm, inside the box. A view.")
      .def_property_readonly(
          "orientation",
          [](const py::object& s) {
            const auto& q = the<Particles>(s).orientation;
            return view(s, reinterpret_cast<const double*>(q.data()),
                        {static_cast<py::ssize_t>(q.size()), 4});
          },
          "float64 (n, 4): unit quaternions x, y, z, w, as scipy.spatial.transform.Rotation takes them. A "
          "view.")
      .def_property_readonly(
          "scale", [](const py::object& s) { return view(s, the<Particles>(s).scale); },
          "float64 (n): factor of the shape's mesh. A view.")
      .def_property_readonly(
          "size", [](const py::object& s) { return view(s, the<Particles>(s).size); },
          "float64 (n): √(4·A_max/π) in mm. A view.")
      .def_property_readonly(
          "color", [](const py::object& s) { return rows(s, the<Particles>(s).color); },
          "float32 (n, 3): scene-linear. A view.")
      .def_property_readonly(
          "binder_color", [](const py::object& s) { return color(the<Particles>(s).binder_color); },
          "Color between the particles, scene-linear.")
      .def_property_readonly(
          "voids",
          [](const py::object& s) {
            const auto& v = the<Particles>(s);
            py::array_t<bool> out(static_cast<py::ssize_t>(v.count()));
            for (std::size_t i = 0; i < v.count(); ++i)
              out.mutable_data()[i] = i < v.voids.size() && v.voids[i] != 0;
            return out;
          },
          "bool (n): which particles are voids. Computed.");
}

}  // namespace terrazzo::python
