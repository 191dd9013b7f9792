// Values as objects whose arrays are views: read-only, without a copy, keeping the value alive.
#include <fmt/format.h>

#include <limits>

#include "graph/nearest.h"
#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/labels.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/strokes.h"
#include "nodes/data/table.h"
#include "runtime/hash.h"
#include "runtime/json_text.h"
#include "runtime/python/value_object.h"

namespace terrazzo::python {
namespace {

using Shape_ = std::vector<py::ssize_t>;  // of arrays; `Shape` is a particle's

// An array that shows memory of a value. `owner` is the object of the value.
py::array view(const py::handle& owner, const py::dtype& type, const void* data, Shape_ shape,
               Shape_ strides) {
  py::array a(type, std::move(shape), std::move(strides), data, owner);
  py::detail::array_proxy(a.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return a;
}

template <class T>
py::array view(const py::handle& owner, const T* data, Shape_ shape) {
  Shape_ strides(shape.size());
  py::ssize_t step = sizeof(T);
  for (std::size_t i = shape.size(); i-- > 0;) strides[i] = step, step *= shape[i];
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
  constexpr auto n = static_cast<py::ssize_t>(sizeof(V) / sizeof(S));
  return view(owner, reinterpret_cast<const S*>(v.data()), {static_cast<py::ssize_t>(v.size()), n});
}

// One member of every element of a list of structures.
template <class S, class Item>
py::array member(const py::handle& owner, const std::vector<Item>& list, const void* of_first,
                 int width = 1) {
  Shape_ shape{static_cast<py::ssize_t>(list.size())}, strides{sizeof(Item)};
  if (width > 1) shape.push_back(width), strides.push_back(sizeof(S));
  return view(owner, py::dtype::of<S>(), of_first, std::move(shape), std::move(strides));
}

template <class T>
const T& the(const py::object& self) {
  return self.cast<const ValueObject&>().value.as<T>();
}

py::array_t<float> color(const Vec3f& c) { return py::array_t<float>(3, c.data()); }
template <class V>
py::tuple tuple_of(const V& v) {
  py::tuple out(v.size());
  for (Eigen::Index i = 0; i < v.size(); ++i) out[static_cast<std::size_t>(i)] = v[i];
  return out;
}

struct ImageObject : ValueObject {
  using ValueObject::ValueObject;
};
struct LabelsObject : ValueObject {
  using ValueObject::ValueObject;
};
struct ProfilesObject : ValueObject {
  using ValueObject::ValueObject;
};
struct SizeDistributionObject : ValueObject {
  using ValueObject::ValueObject;
};
struct ShapesObject : ValueObject {
  using ValueObject::ValueObject;
};
struct ParticlesObject : ValueObject {
  using ValueObject::ValueObject;
};
struct TableObject : ValueObject {
  using ValueObject::ValueObject;
};
struct KMatrixObject : ValueObject {
  using ValueObject::ValueObject;
};
struct StrokesObject : ValueObject {
  using ValueObject::ValueObject;
};
struct DetailObject : ValueObject {
  using ValueObject::ValueObject;
};

template <class S>
Shape_ pixels_shape(const S& v, bool color) {
  Shape_ shape;
  if (v.sections != 1) shape.push_back(v.sections);
  shape.push_back(v.height), shape.push_back(v.width);
  if (color) shape.push_back(3);
  return shape;
}

// --- parts of values: they refer to the object of the whole

struct ShapePart {
  py::object owner;
  const Shape* shape;
};
struct MeshPart {
  py::object owner;
  const Mesh* mesh;
};
struct EntryPart {
  py::object owner;
  const SizeDistribution::Entry* entry;
};
struct KEntryPart {
  py::object owner;
  const KMatrix::Entry* entry;
};
struct StrokePart {
  py::object owner;
  const Stroke* stroke;
};
struct PhasePart {
  py::object owner;
  const Detail::Phase* phase;
};

template <class Part, class List>
py::list parts(const py::object& self, const List& list) {
  py::list out;
  for (const auto& item : list) out.append(Part{self, &item});
  return out;
}

void bind_pictures(py::module_& m) {
  py::class_<ImageObject, ValueObject>(
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
  py::class_<LabelsObject, ValueObject>(m, "Labels",
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
  py::class_<ProfilesObject, ValueObject> c(
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
  TERRAZZO_MEMBER("color", float, color, 3, "float32 (n, 3): mean color, scene-linear. A view.");
#undef TERRAZZO_MEMBER
  c.def(
      "contour",
      [](const py::object& s, py::ssize_t i) {
        const auto& p = the<Profiles>(s).profiles;
        const auto n = static_cast<py::ssize_t>(p.size());
        if (i < -n || i >= n) throw py::index_error(fmt::format("there is no profile {} of {}", i, n));
        return rows(s, p[static_cast<std::size_t>(i < 0 ? i + n : i)].contour);
      },
      py::arg("index"),
      "float64 (m, 2): the outer outline of one profile in mm like `centroid`, counterclockwise, the first "
      "point not repeated; may be empty. A view.");
}

void bind_sizes(py::module_& m) {
  py::class_<EntryPart>(m, "SizeDistributionEntry", "The densities of one shape and class.")
      .def_property_readonly(
          "shape", [](const EntryPart& p) { return p.entry->shape; },
          "Number of the shape; −1: any shape, by the probabilities of the shapes.")
      .def_property_readonly(
          "cls", [](const EntryPart& p) { return p.entry->cls; }, "Color or particle class.")
      .def_property_readonly(
          "N_V", [](const EntryPart& p) { return view(p.owner, p.entry->N_V); },
          "float64 (n): particles per mm³ in each size class. A view.")
      .def_property_readonly(
          "low", [](const EntryPart& p) { return view(p.owner, p.entry->low); },
          "float64 (n): lower ends of the 90 % intervals of N_V. A view.")
      .def_property_readonly(
          "high", [](const EntryPart& p) { return view(p.owner, p.entry->high); },
          "float64 (n): upper ends of the 90 % intervals of N_V. A view.");
  py::class_<SizeDistributionObject, ValueObject>(
      m, "SizeDistribution",
      "Number of particles per volume in each size class. A size is √(4·A_max/π), with A_max the "
      "area of the particle's largest section.")
      .def_property_readonly(
          "class_edges", [](const py::object& s) { return view(s, the<SizeDistribution>(s).class_edges); },
          "float64 (n + 1): increasing sizes in mm. A view.")
      .def_property_readonly(
          "entries", [](const py::object& s) { return parts<EntryPart>(s, the<SizeDistribution>(s).shapes); },
          "One SizeDistributionEntry for each shape and class.")
      .def_property_readonly(
          "N_V",
          [](const py::object& s) {
            const auto& v = the<SizeDistribution>(s);
            py::array_t<double> out(static_cast<py::ssize_t>(v.classes()));
            double* at = out.mutable_data();
            std::fill(at, at + v.classes(), 0.0);
            for (const auto& e : v.shapes)
              for (std::size_t i = 0; i < v.classes(); ++i) at[i] += e.N_V[i];
            return out;
          },
          "float64 (n): particles per mm³ in each size class, over all shapes and classes. Computed.")
      .def_property_readonly(
          "volume_fraction", [](const py::object& s) { return the<SizeDistribution>(s).volume_fraction; },
          "Volume of the particles divided by the volume.")
      .def_property_readonly(
          "d_max", [](const py::object& s) { return the<SizeDistribution>(s).d_max; },
          "Size of the largest particle in mm.")
      .def_property_readonly(
          "goodness_of_fit", [](const py::object& s) { return the<SizeDistribution>(s).goodness_of_fit; },
          "χ² per degree of freedom of the refitted N_A; 0 without a fit.");
}

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
          "no "
          "rows. A view.")
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
  py::class_<ShapesObject, ValueObject>(m, "Shapes", "Particle shapes with probabilities.")
      .def("__len__", [](const py::object& s) { return the<Shapes>(s).shapes.size(); })
      .def("__getitem__", [](const py::object& s, py::ssize_t i) {
        const auto& v = the<Shapes>(s).shapes;
        const auto n = static_cast<py::ssize_t>(v.size());
        if (i < -n || i >= n) throw py::index_error(fmt::format("there is no shape {} of {}", i, n));
        return ShapePart{s, &v[static_cast<std::size_t>(i < 0 ? i + n : i)]};
      });
}

void bind_particles(py::module_& m) {
  py::class_<ParticlesObject, ValueObject>(
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

py::object cell(const Table::Cell& c) {
  if (const auto* number = std::get_if<double>(&c)) return py::float_(*number);
  return py::str(std::get<std::string>(c));
}

void bind_tables(py::module_& m) {
  py::class_<TableObject, ValueObject>(m, "Table",
                                       "Named columns of numbers or text. table['N_V mm⁻³'] is a column.")
      .def("__len__", [](const py::object& s) { return the<Table>(s).rows.size(); })
      .def_property_readonly(
          "columns", [](const py::object& s) { return the<Table>(s).columns; },
          "Names of the columns, with units.")
      .def_property_readonly(
          "rows",
          [](const py::object& s) {
            py::list out;
            for (const auto& row : the<Table>(s).rows) {
              py::list cells;
              for (const auto& c : row) cells.append(cell(c));
              out.append(py::tuple(cells));
            }
            return out;
          },
          "The rows as tuples.")
      .def(
          "__getitem__",
          [](const py::object& s, const std::string& name) -> py::object {
            const auto& t = the<Table>(s);
            const int at = t.column(name);
            if (at < 0)
              throw Error("no-column",
                          fmt::format("the table has no column '{}'{}", name, did_you_mean(name, t.columns)),
                          fmt::format("columns: {}", fmt::join(t.columns, ", ")));
            const auto k = static_cast<std::size_t>(at);
            bool numbers = true;
            for (const auto& row : t.rows) numbers = numbers && k < row.size() && row[k].index() == 0;
            if (numbers) {
              py::array_t<double> out(static_cast<py::ssize_t>(t.rows.size()));
              for (std::size_t i = 0; i < t.rows.size(); ++i)
                out.mutable_data()[i] = std::get<double>(t.rows[i][k]);
              return out;
            }
            py::list out;
            for (const auto& row : t.rows) out.append(k < row.size() ? cell(row[k]) : py::str(""));
            return out;
          },
          py::arg("column"), "A column: float64 (n) if all of it are numbers, otherwise a list. Copied.");
}

void bind_others(py::module_& m) {
  py::class_<KEntryPart>(m, "KMatrixEntry", "The section statistics of one shape.")
      .def_property_readonly(
          "probability", [](const KEntryPart& p) { return p.entry->probability; },
          "Fraction of all particles, by number.")
      .def_property_readonly(
          "mean_caliper", [](const KEntryPart& p) { return p.entry->mean_caliper; },
          "Mean caliper diameter in mm, at scale 1.")
      .def_property_readonly(
          "max_section_area", [](const KEntryPart& p) { return p.entry->max_section_area; },
          "mm², at scale 1.")
      .def_property_readonly(
          "volume", [](const KEntryPart& p) { return p.entry->volume; }, "mm³, at scale 1.")
      .def_property_readonly(
          "K",
          [](const KEntryPart& p) {
            const auto& k = p.entry->K;  // by column
            return view(p.owner, py::dtype::of<double>(), k.data(),
                        {static_cast<py::ssize_t>(k.rows()), static_cast<py::ssize_t>(k.cols())},
                        {sizeof(double), static_cast<py::ssize_t>(sizeof(double)) * k.rows()});
          },
          "float64 (n, n): row: profile class, column: particle class. A view.")
      .def_property_readonly(
          "cdf", [](const KEntryPart& p) { return view(p.owner, p.entry->cdf); },
          "float64: share of the profiles with √(A/A_max) ≤ (b + 1) / len(cdf). A view.");
  py::class_<KMatrixObject, ValueObject>(
      m, "KMatrix", "Frequency of profiles of each size class from particles of each size class.")
      .def_property_readonly(
          "classes", [](const py::object& s) { return the<KMatrix>(s).classes; }, "Number of classes.")
      .def_property_readonly(
          "residual", [](const py::object& s) { return the<KMatrix>(s).residual; },
          "Largest relative change of a class between half of the samples and all.")
      .def_property_readonly(
          "entries", [](const py::object& s) { return parts<KEntryPart>(s, the<KMatrix>(s).shapes); },
          "One KMatrixEntry for each shape.");
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
  py::class_<StrokesObject, ValueObject>(m, "Strokes", "Strokes on an image, in drawing order.")
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
  py::class_<DetailObject, ValueObject>(m, "Detail", "What a photograph shows beyond flat colors.")
      .def_property_readonly(
          "pixel_size", [](const py::object& s) { return the<Detail>(s).pixel_size; },
          "Edge of the tiles' voxels in mm.")
      .def_property_readonly(
          "size", [](const py::object& s) { return the<Detail>(s).size; }, "Edge of the tiles in voxels.")
      .def_property_readonly(
          "phases", [](const py::object& s) { return parts<PhasePart>(s, the<Detail>(s).phases); },
          "The binder, then groups of particles: DetailPhase.");
}

}  // namespace

Hash content_of(const Value& v) {
  HashWriter w;
  w.text(v.type().name);
  v.type().encode(v.data(), w);
  return w.hash();
}

py::object to_python(const Value& v) {
  const std::string& name = v.type().name;
  const auto object = [&]<class O>() { return py::cast(O(v)); };
  if (name == "Image") return object.operator()<ImageObject>();
  if (name == "Labels") return object.operator()<LabelsObject>();
  if (name == "Profiles") return object.operator()<ProfilesObject>();
  if (name == "SizeDistribution") return object.operator()<SizeDistributionObject>();
  if (name == "Shapes") return object.operator()<ShapesObject>();
  if (name == "Particles") return object.operator()<ParticlesObject>();
  if (name == "Table") return object.operator()<TableObject>();
  if (name == "KMatrix") return object.operator()<KMatrixObject>();
  if (name == "Strokes") return object.operator()<StrokesObject>();
  if (name == "Detail") return object.operator()<DetailObject>();
  if (name == "Volume") return volume_object(v);
  return object.operator()<ValueObject>();  // of a plugin: describe() shows it
}

bool is_value(const py::handle& h) { return py::isinstance<ValueObject>(h); }

const Value& to_value(const py::handle& h) {
  if (!is_value(h))
    throw Error("wrong-type", "expected a value of terrazzo, got " + std::string(Py_TYPE(h.ptr())->tp_name),
                "make one with terrazzo.image, labels, mesh or sizes");
  return h.cast<const ValueObject&>().value;
}

void bind_values(py::module_& m) {
  py::class_<ValueObject>(m, "Value", "A value of a graph.", py::dynamic_attr())
      .def_property_readonly(
          "type", [](const ValueObject& v) { return v.value.type().name; }, "Name of the value's type.")
      .def_property_readonly(
          "content", [](const ValueObject& v) { return content_of(v.value).text(); },
          "Hash of the value's content. Equal values have equal hashes.")
      .def(
          "describe",
          [](const ValueObject& v) { return from_json(json_text(v.value.type().describe(v.value.data()))); },
          "The value as dictionaries and lists, like `terrazzo show --json`.")
      .def("__eq__",
           [](const ValueObject& a, const py::object& b) {
             if (!is_value(b)) return false;
             const Value& other = to_value(b);
             return a.value.data() == other.data() ||
                    (a.value.type().name == other.type().name && content_of(a.value) == content_of(other));
           })
      .def("__hash__", [](const ValueObject& v) { return content_of(v.value).low; })
      .def("_encoded", [](const ValueObject& v) {
        BufferWriter w;
        v.value.type().encode(v.value.data(), w);
        return py::bytes(w.buffer.data(), w.buffer.size());
      });
  m.def("decoded", [](const std::string& type, const py::bytes& bytes) {
    const ValueType* t = value_types().find(type);
    if (!t) throw Error("wrong-type", "there is no value type '" + type + "'");
    const auto text = static_cast<std::string_view>(bytes);
    Reader r(text.data(), text.size());
    Value v(t, t->decode(r));
    if (r.left() > 0) throw Error("damaged", "the stored value is too long");
    return to_python(v);
  });
  bind_pictures(m);
  bind_profiles(m);
  bind_sizes(m);
  bind_shapes(m);
  bind_particles(m);
  bind_tables(m);
  bind_others(m);
}

}  // namespace terrazzo::python
