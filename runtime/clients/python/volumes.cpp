// Volumes: grids as dense arrays, on request.
#include <fmt/format.h>

#include <openvdb/tools/Dense.h>

#include <limits>
#include <numeric>

#include "graph/text/nearest.h"
#include "nodes/data/volume.h"
#include "runtime/clients/python/outside.h"
#include "runtime/clients/python/value_object.h"
#include "runtime/memory.h"

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

template <class Grid, class Scalar>
py::array dense(const openvdb::GridBase& any, int width, const openvdb::CoordBBox& box) {
  const auto& g = static_cast<const Grid&>(any);
  std::vector<py::ssize_t> shape{0, 0, 0};
  for (int k = 0; k < 3 && !box.empty(); ++k) {
    shape[k] = py::ssize_t{box.max()[k]} - box.min()[k] + 1;
    if (shape[k] > std::numeric_limits<int>::max())  // OpenVDB counts with int
      throw Error("too-large", fmt::format("the voxels of the grid '{}' lie too far apart for a dense array",
                                           g.getName()));
  }
  const double bytes = static_cast<double>(shape[0]) * shape[1] * shape[2] * width * sizeof(Scalar);
  require_memory(bytes, available_memory(), fmt::format("a dense array of the grid '{}'", g.getName()));
  if (width > 1) shape.push_back(width);
  py::array_t<Scalar> out(shape);
  if (box.empty()) return out;
  using T = typename Grid::ValueType;
  static_assert(sizeof(T) % sizeof(Scalar) == 0);
  T* data = reinterpret_cast<T*>(out.mutable_data());
  const Outside outside;
  openvdb::tools::Dense<T, openvdb::tools::LayoutZYX> target(box, data);
  openvdb::tools::copyToDense(g, target);
  return out;
}

py::array dense_by_type(const openvdb::GridBase& g, const openvdb::CoordBBox& box) {
  if (g.isType<openvdb::FloatGrid>()) return dense<openvdb::FloatGrid, float>(g, 1, box);
  if (g.isType<openvdb::DoubleGrid>()) return dense<openvdb::DoubleGrid, double>(g, 1, box);
  if (g.isType<openvdb::Int32Grid>()) return dense<openvdb::Int32Grid, std::int32_t>(g, 1, box);
  if (g.isType<openvdb::BoolGrid>()) return dense<openvdb::BoolGrid, bool>(g, 1, box);
  if (g.isType<openvdb::Vec3SGrid>()) return dense<openvdb::Vec3SGrid, float>(g, 3, box);
  if (g.isType<openvdb::Vec3IGrid>()) return dense<openvdb::Vec3IGrid, std::int32_t>(g, 3, box);
  throw Error("unsupported-grid", fmt::format("the grid '{}' has the type {}", g.getName(), g.type()));
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
            const auto box = voxels_of(the_volume(v), grid(the_volume(v), name));
            if (box.empty()) return py::make_tuple(0, 0, 0);
            return py::make_tuple(box.min().x(), box.min().y(), box.min().z());
          },
          py::arg("name"), "The voxel that is the first element of dense(name).")
      .def(
          "dense",
          [](const VolumeObject& v, const std::string& name) {
            const openvdb::GridBase& g = grid(the_volume(v), name);
            return dense_by_type(g, voxels_of(the_volume(v), g));
          },
          py::arg("name"),
          "A grid as a new array (nx, ny, nz), or (nx, ny, nz, 3) for vectors: one period, or all voxels "
          "that were given or made if the volume does not tile. If neither is known, as for OpenVDB files "
          "of other programs, the grid's active voxels. Fails if the memory does not suffice.")
      .def_property_readonly(
          "extent",
          [](const VolumeObject& v) {
            const Vec3i n = the_volume(v).has_extent() ? the_volume(v).extent : Vec3i::Zero().eval();
            return py::make_tuple(n.x(), n.y(), n.z());
          },
          "Voxels along x, y, z of a volume that does not tile; zeros if it tiles, or if they are not known.")
      .def("_plane", [](const VolumeObject& v, const std::string& name) {  // the middle one along z
        const openvdb::GridBase& g = grid(the_volume(v), name);
        openvdb::CoordBBox box = voxels_of(the_volume(v), g);
        if (!box.empty()) box.min().z() = box.max().z() = std::midpoint(box.min().z(), box.max().z());
        return dense_by_type(g, box);
      });
}

}  // namespace terrazzo::python
