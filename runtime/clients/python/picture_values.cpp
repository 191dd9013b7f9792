// Images, labels and profiles.
#include <fmt/format.h>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "runtime/clients/python/value_views.h"

namespace terrazzo::python {
namespace {

template <class S>
Shape_ pixels_shape(const S& v, bool color) {
  Shape_ shape;
  if (v.sections != 1) shape.push_back(v.sections);
  shape.push_back(v.height);
  shape.push_back(v.width);
  if (color) shape.push_back(3);
  return shape;
}

}  // namespace

void bind_pictures(py::module_& m) {
  py::class_<ObjectOf<Image>, ValueObject>(
      m, "Image",
      "One section, or a stack of sections of equal scale; scene-linear Rec. 709.\n\n"
      "As an array (numpy.asarray): `pixels`.")
      .def_property_readonly(
          "width", [](const py::object& s) { return the<Image>(s).width; }, "Pixels.")
      .def_property_readonly(
          "height", [](const py::object& s) { return the<Image>(s).height; }, "Pixels.")
      .def_property_readonly(
          "sections", [](const py::object& s) { return the<Image>(s).sections; }, "Number of sections.")
      .def_property_readonly(
          "pixel_size", [](const py::object& s) { return the<Image>(s).pixel_size; },
          "Edge of a pixel in mm.")
      .def_property_readonly(
          "pixels",
          [](const py::object& s) {
            const auto& v = the<Image>(s);
            return view(s, reinterpret_cast<const float*>(v.pixels.data()), pixels_shape(v, true));
          },
          "float32 (height, width, 3), or (sections, height, width, 3) for a stack: scene-linear colors. "
          "A view, rows from the top.");
  py::class_<ObjectOf<Labels>, ValueObject>(m, "Labels",
                                            "The profile number of each pixel.\n\n"
                                            "As an array (numpy.asarray): `ids`.")
      .def_property_readonly(
          "width", [](const py::object& s) { return the<Labels>(s).width; }, "Pixels.")
      .def_property_readonly(
          "height", [](const py::object& s) { return the<Labels>(s).height; }, "Pixels.")
      .def_property_readonly(
          "sections", [](const py::object& s) { return the<Labels>(s).sections; }, "Number of sections.")
      .def_property_readonly(
          "pixel_size", [](const py::object& s) { return the<Labels>(s).pixel_size; },
          "Edge of a pixel in mm.")
      .def_property_readonly(
          "count", [](const py::object& s) { return the<Labels>(s).count(); }, "Number of profiles.")
      .def_property_readonly(
          "ids",
          [](const py::object& s) {
            const auto& v = the<Labels>(s);
            return view(s, v.ids.data(), pixels_shape(v, false));
          },
          "int32 (height, width), or (sections, height, width) for a stack: 0 is binder, profiles are "
          "numbered from 1 through all sections. A view.")
      .def_property_readonly(
          "classes", [](const py::object& s) { return view(s, the<Labels>(s).classes); },
          "int32 (count): the class of profile k at k − 1, from 0. A view.");
}

void bind_profiles(py::module_& m) {
  py::class_<ObjectOf<Profiles>, ValueObject> c(
      m, "Profiles", "Profiles of particles in plane sections. Arrays have an element for each profile.");
  c.def("__len__", [](const py::object& s) { return the<Profiles>(s).profiles.size(); });
  c.def_property_readonly(
      "observed_area", [](const py::object& s) { return the<Profiles>(s).observed_area; },
      "Area of all sections in mm²; 0 if unknown, and densities are then relative.");
  c.def_property_readonly(
      "sections", [](const py::object& s) { return the<Profiles>(s).sections; }, "Number of sections.");
  c.def_property_readonly(
      "class_count", [](const py::object& s) { return the<Profiles>(s).classes; },
      "Number of color or particle classes.");
  c.def_property_readonly(
      "window", [](const py::object& s) { return tuple_of(the<Profiles>(s).window); },
      "Width and height of one section in mm; 0 if unknown.");
  c.def_property_readonly(
      "binder_color", [](const py::object& s) { return color(the<Profiles>(s).binder_color); },
      "Mean color of all pixels outside profiles, scene-linear.");
  c.def_property_readonly(
      "area_fraction", [](const py::object& s) { return the<Profiles>(s).area_fraction; },
      "Pixels in profiles divided by all pixels, border profiles included.");
  static const Profile none;
  const auto first = [](const std::vector<Profile>& p) -> const Profile& { return p.empty() ? none : p[0]; };
#define TERRAZZO_MEMBER(NAME, TYPE, FIELD, WIDTH, DOC)                               \
  c.def_property_readonly(                                                           \
      NAME,                                                                          \
      [first](const py::object& s) {                                                 \
        const auto& p = the<Profiles>(s).profiles;                                   \
        return member<TYPE>(s, p, static_cast<const void*>(&first(p).FIELD), WIDTH); \
      },                                                                             \
      DOC)
  TERRAZZO_MEMBER("section", int, section, 1, "int32 (n): number of the section, from 0. A view.");
  TERRAZZO_MEMBER("cls", int, cls, 1, "int32 (n): color or particle class, from 0. A view.");
  TERRAZZO_MEMBER("area", double, area, 1, "float64 (n): area in mm². A view.");
  TERRAZZO_MEMBER("centroid", double, centroid, 2,
                  "float64 (n, 2): mm from the section's lower left corner, y up. A view.");
  TERRAZZO_MEMBER("touches_border", bool, touches_border, 1,
                  "bool (n): whether the profile touches the border of its section. A view.");
  TERRAZZO_MEMBER("weight", double, weight, 1,
                  "float64 (n): number of profiles that each one represents (border correction). A view.");
  TERRAZZO_MEMBER("confidence", double, confidence, 1,
                  "float64 (n): how likely each one is a particle, outlined correctly. A view.");
  TERRAZZO_MEMBER("color", float, color, 3, "float32 (n, 3): median color, scene-linear. A view.");
#undef TERRAZZO_MEMBER
  c.def(
      "contour",
      [](const py::object& s, py::ssize_t i) {
        const auto& p = the<Profiles>(s).profiles;
        const py::ssize_t n = p.size();
        if (i < -n || i >= n) throw py::index_error(fmt::format("there is no profile {} of {}", i, n));
        return rows(s, p[i < 0 ? i + n : i].contour);
      },
      py::arg("index"),
      "float64 (m, 2): the outer outline of one profile in mm like `centroid`, counterclockwise, the first "
      "point not repeated; may be empty. A view.");
}

}  // namespace terrazzo::python
