// Strokes and detail.
#include <fmt/format.h>

#include "nodes/data/detail.h"
#include "nodes/data/strokes.h"
#include "runtime/clients/python/value_views.h"

namespace terrazzo::python {
namespace {

struct StrokePart {
  py::object owner;
  const Stroke* stroke;
};
struct PhasePart {
  py::object owner;
  const Detail::Phase* phase;
};

}  // namespace

void bind_strokes(py::module_& m) {
  py::class_<StrokePart>(m, "Stroke", "A line or an area on an image.")
      .def_property_readonly(
          "radius", [](const StrokePart& p) { return p.stroke->radius; }, "Radius of the nib in pixels.")
      .def_property_readonly(
          "area", [](const StrokePart& p) { return p.stroke->area; }, "Whether the outlines are filled.")
      .def_property_readonly(
          "parts",
          [](const StrokePart& p) {
            py::list out;
            for (const auto& part : p.stroke->parts) out.append(rows(p.owner, part));
            return out;
          },
          "A list of float64 (n, 2): pixels from the top left corner, y down. Views.");
  py::class_<ObjectOf<Strokes>, ValueObject>(m, "Strokes", "Strokes on an image, in drawing order.")
      .def("__len__", [](const py::object& s) { return the<Strokes>(s).strokes.size(); })
      .def_property_readonly(
          "strokes", [](const py::object& s) { return parts<StrokePart>(s, the<Strokes>(s).strokes); },
          "A list of Stroke.");
  py::class_<PhasePart>(m, "DetailPhase", "The detail of the binder or of a group of particles.")
      .def_property_readonly(
          "color", [](const PhasePart& p) { return color(p.phase->color); }, "Mean color, scene-linear.")
      .def_property_readonly(
          "tile", [](const PhasePart& p) { return rows(p.owner, p.phase->tile); },
          "float32 (size³, 3): offsets of sRGB-encoded colors, x fastest. A view.");
  py::class_<ObjectOf<Detail>, ValueObject>(m, "Detail", "What a photograph shows beyond flat colors.")
      .def_property_readonly(
          "pixel_size", [](const py::object& s) { return the<Detail>(s).pixel_size; },
          "Edge of the tiles' voxels in mm.")
      .def_property_readonly(
          "size", [](const py::object& s) { return the<Detail>(s).size; }, "Edge of the tiles in voxels.")
      .def_property_readonly(
          "phases", [](const py::object& s) { return parts<PhasePart>(s, the<Detail>(s).phases); },
          "The binder, then groups of particles: DetailPhase.");
}

}  // namespace terrazzo::python
