// Volumes: grids as dense arrays, on request.
#include <fmt/format.h>

#include <openvdb/tools/Dense.h>

#include "graph/nearest.h"
#include "nodes/data/volume.h"
#include "runtime/memory.h"
#include "runtime/python/value_object.h"

namespace terrazzo::python {
namespace {

struct VolumeObject : ValueObject {
  using ValueObject::ValueObject;
};

const Volume& the_volume(const VolumeObject& v) { return v.value.as<Volume>(); }

std::vector<std::string> grid_names(const Volume& v) {
  std::vector<std::string> out;
  for (const auto& g : v.grids) out.push_back(g->getName());
  return out;
}

const openvdb::GridBase& grid(const Volume& v, const std::string& name) {
  for (const auto& g : v.grids)
    if (g->getName() == name) return *g;
  throw Error("no-grids",
              fmt::format("the volume has no grid '{}'{}", name, did_you_mean(name, grid_names(v))),
              fmt::format("grids: {}", fmt::join(grid_names(v), ", ")));
}

// One period if the volume tiles, otherwise the active voxels.
openvdb::CoordBBox box_of(const Volume& v, const openvdb::GridBase& g) {
  if (v.resolution.minCoeff() > 0)
    return {openvdb::Coord(0),
            openvdb::Coord(v.resolution.x() - 1, v.resolution.y() - 1, v.resolution.z() - 1)};
  return g.evalActiveVoxelBoundingBox();
}

template <class Grid, class Scalar>
py::array dense(const Volume& v, const openvdb::GridBase& any, int width) {
  const auto& g = static_cast<const Grid&>(any);
  const openvdb::CoordBBox box = box_of(v, g);
  std::vector<py::ssize_t> shape{0, 0, 0};
  if (!box.empty()) shape = {box.dim().x(), box.dim().y(), box.dim().z()};
  const double bytes = static_cast<double>(shape[0]) * shape[1] * shape[2] * width * sizeof(Scalar);
  require_memory(bytes, available_memory(), fmt::format("a dense array of the grid '{}'", g.getName()));
  if (width > 1) shape.push_back(width);
  py::array_t<Scalar> out(shape);
  if (box.empty()) return out;
  using T = typename Grid::ValueType;
  static_assert(sizeof(T) % sizeof(Scalar) == 0);
  T* data = reinterpret_cast<T*>(out.mutable_data());
  const py::gil_scoped_release without_gil;
  openvdb::tools::Dense<T, openvdb::tools::LayoutZYX> target(box, data);
  openvdb::tools::copyToDense(g, target);
  return out;
}

py::array dense_by_type(const Volume& v, const std::string& name) {
  const openvdb::GridBase& g = grid(v, name);
  if (g.isType<openvdb::FloatGrid>()) return dense<openvdb::FloatGrid, float>(v, g, 1);
  if (g.isType<openvdb::DoubleGrid>()) return dense<openvdb::DoubleGrid, double>(v, g, 1);
  if (g.isType<openvdb::Int32Grid>()) return dense<openvdb::Int32Grid, std::int32_t>(v, g, 1);
  if (g.isType<openvdb::BoolGrid>()) return dense<openvdb::BoolGrid, bool>(v, g, 1);
  if (g.isType<openvdb::Vec3SGrid>()) return dense<openvdb::Vec3SGrid, float>(v, g, 3);
  if (g.isType<openvdb::Vec3IGrid>()) return dense<openvdb::Vec3IGrid, std::int32_t>(v, g, 3);
  throw Error("unsupported-grid", fmt::format("the grid '{}' has the type {}", name, g.type()));
}

}  // namespace

py::object volume_object(const Value& v) { return py::cast(VolumeObject(v)); }

void bind_volumes(py::module_& m) {
  py::class_<VolumeObject, ValueObject>(m, "Volume", "Named OpenVDB grids in one box.")
      .def_property_readonly(
          "grids", [](const VolumeObject& v) { return grid_names(the_volume(v)); }, "Names of the grids.")
      .def_property_readonly(
          "resolution",
          [](const VolumeObject& v) {
            const Vec3i r = the_volume(v).resolution;
            return py::make_tuple(r.x(), r.y(), r.z());
          },
          "Voxels of one period along x, y, z; zeros if the volume does not tile.")
      .def_property_readonly(
          "voxel_size",
          [](const VolumeObject& v) {
            const auto& grids = the_volume(v).grids;
            return grids.empty() ? 0.0 : grids[0]->voxelSize().x();
          },
          "Edge of a voxel along x in mm.")
      .def(
          "origin",
          [](const VolumeObject& v, const std::string& name) {
            const auto box = box_of(the_volume(v), grid(the_volume(v), name));
            if (box.empty()) return py::make_tuple(0, 0, 0);
            return py::make_tuple(box.min().x(), box.min().y(), box.min().z());
          },
          py::arg("name"), "The voxel that is the first element of dense(name).")
      .def(
          "dense",
          [](const VolumeObject& v, const std::string& name) { return dense_by_type(the_volume(v), name); },
          py::arg("name"),
          "A grid as a new array (nx, ny, nz), or (nx, ny, nz, 3) for vectors: one period, or the active "
          "voxels if the volume does not tile. Fails if the memory does not suffice.");
}

}  // namespace terrazzo::python
