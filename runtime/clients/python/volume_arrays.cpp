// Arrays of the user as grids, and the period of a volume.
#include <algorithm>
#include <limits>

#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/geometry/grid/smallest_voxel.h"
#include "nodes/common/geometry/grid/spaced_transform.h"
#include "nodes/data/volume.h"
#include "runtime/clients/python/array_input.h"
#include "runtime/clients/python/run_object.h"

namespace terrazzo::python {
namespace {

constexpr py::ssize_t kMostVoxels = 1 << 24;  // along an axis

Vec3 spacing_of(const std::vector<double>& given) {
  if (given.size() != 1 && given.size() != 3)
    throw Error("wrong-count", "voxel_size is one number, or three for x, y and z").parameter("voxel_size");
  Vec3 out;
  for (int k = 0; k < 3; ++k) {
    out[k] = given[given.size() == 3 ? static_cast<std::size_t>(k) : 0];
    require_length(out[k], "voxel_size");
  }
  if (out.prod() < kSmallestVoxel)
    throw Error("bad-value",
                fmt::format("voxels of {} × {} × {} mm are too small: grids hold them from about 15 nm on",
                            out[0], out[1], out[2]))
        .parameter("voxel_size");
  return out;
}

// The grid of an array whose last index is the fastest: `components` numbers for each (x, y, z).
template <class Grid, class Number>
typename Grid::Ptr grid_of(const std::string& name, const Vec3i& size, const Vec3& spacing,
                           const Number* data) {
  using T = typename Grid::ValueType;
  constexpr std::size_t kComponents = sizeof(T) / sizeof(Number);
  const std::size_t nx = size.x(), ny = size.y(), nz = size.z();
  auto grid = dense_grid<Grid>(name.c_str(), size, 1, Work(), [&](std::size_t i) {
    const Number* at = data + ((i % nx * ny + i / nx % ny) * nz + i / nx / ny) * kComponents;
    if constexpr (kComponents == 1)
      return *at;
    else
      return T(at[0], at[1], at[2]);
  });
  grid->setTransform(voxel_transform(spacing));
  return grid;
}

// Whole numbers that floats would round are refused.
void require_exact(const py::array& a) {
  if (!is_whole(a)) return;
  const auto data = numbers<std::int64_t>(a, "the volume");
  const bool no_sign = a.dtype().kind() == 'u';
  const std::int64_t* in = data.data();
  const std::size_t n = data.size();
  const Outside outside;
  const auto bad = std::find_if(in, in + n, [&](std::int64_t v) {
    // Compared as doubles, which hold what a float can hold.
    return (no_sign && v < 0) || std::abs(v) > (std::int64_t{1} << 53) ||
           static_cast<double>(static_cast<float>(v)) != v;
  });
  if (bad != in + n)
    throw Error("bad-values",
                no_sign && *bad < 0 ? "a voxel of the volume is above 2⁶³"
                                    : fmt::format("a voxel of the volume is {}, which float32 rounds", *bad),
                "pass labels with name=\"id\", or floats");
}

py::object volume(const py::object& object, const std::vector<double>& voxel_size, const std::string& name) {
  const py::array a = array_of(object, "the volume");
  const bool vectors = a.ndim() == 4 && a.shape(3) == 3;
  if (a.ndim() != 3 && !vectors)
    throw Error("wrong-shape",
                fmt::format("a volume has the shape (nx, ny, nz), or (nx, ny, nz, 3) for vectors, not {}",
                            text_of(a)));
  if (name.empty()) throw Error("bad-name", "the name of a grid must not be empty").parameter("name");
  const Vec3 spacing = spacing_of(voxel_size);
  Vec3i size;
  for (int k = 0; k < 3; ++k) {
    if (a.shape(k) < 1) throw Error("empty-volume", fmt::format("the volume is empty: {}", text_of(a)));
    if (a.shape(k) > kMostVoxels)
      throw Error("too-large",
                  fmt::format("the volume has more than 2²⁴ voxels along an axis: {}", text_of(a)));
    size[k] = a.shape(k);
  }
  const bool ids = name == "id";
  if (ids && (vectors || !is_whole(a)))
    throw Error("wrong-type", fmt::format("the grid id holds the numbers of particles, not {}", text_of(a)),
                "pass whole numbers of the shape (nx, ny, nz), or another name");
  require_memory(static_cast<double>(a.size()) * 5, available_memory(), "the volume");
  if (!ids) require_exact(a);
  initialize_openvdb();
  Volume out;
  out.extent = size;
  const bool no_sign = a.dtype().kind() == 'u';
  const auto add = [&]<class Grid, class Number>(const py::array_t<Number, py::array::c_style>& data) {
    const Number* in = data.data();
    const std::size_t n = data.size();
    const Outside outside;
    const auto bad = std::find_if(in, in + n, [&](Number v) {
      if constexpr (std::is_integral_v<Number>)
        return (no_sign && v < 0) || v < std::numeric_limits<std::int32_t>::min() ||
               v > std::numeric_limits<std::int32_t>::max();
      else
        return !std::isfinite(v);
    });
    if (bad != in + n)
      throw Error("bad-values",
                  no_sign && *bad < 0 ? "a voxel of the volume is above 2⁶³"
                                      : fmt::format("a voxel of the volume is {}", *bad),
                  "replace NaN, infinite values and whole numbers beyond 32 bits");
    if constexpr (std::is_integral_v<Number>) {
      const std::vector<std::int32_t> whole(in, in + n);
      const auto grid = grid_of<Grid, std::int32_t>(name, size, spacing, whole.data());
      mark_binder(*grid);
      out.grids.push_back(grid);
    } else {
      out.grids.push_back(grid_of<Grid, Number>(name, size, spacing, in));
    }
  };
  require_workers();  // grids are made in parallel
  if (ids)
    add.operator()<openvdb::Int32Grid, std::int64_t>(numbers<std::int64_t>(a, "the volume"));
  else if (vectors)
    add.operator()<openvdb::Vec3SGrid, float>(numbers<float>(a, "the volume"));
  else
    add.operator()<openvdb::FloatGrid, float>(numbers<float>(a, "the volume"));
  return to_python(Value::of(std::move(out)));
}

// The same grids as one period of a volume that tiles.
py::object with_period(const py::object& object, const std::vector<py::ssize_t>& period) {
  Volume out = the<Volume>(object);
  out.first = out.extent = Vec3i::Zero();
  if (period.size() != 3)
    throw Error("wrong-count", "a period is three numbers of voxels").parameter("period");
  for (int k = 0; k < 3; ++k) {
    const py::ssize_t n = period[k];
    if (n < 1 || n > kMostVoxels)
      throw Error("bad-value", fmt::format("a period is 1 to 2²⁴ voxels along each axis, not {}", n))
          .parameter("period");
    out.resolution[k] = n;
  }
  const openvdb::Coord last(out.resolution.x() - 1, out.resolution.y() - 1, out.resolution.z() - 1);
  for (const auto& grid : out.grids) {
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    if (!box.empty() && !openvdb::CoordBBox(openvdb::Coord(0), last).isInside(box))
      throw Error(
          "bad-value",
          fmt::format("the grid '{}' has voxels from ({}, {}, {}) to ({}, {}, {}), beyond the period of "
                      "{} × {} × {} voxels that starts at (0, 0, 0)",
                      grid->getName(), box.min().x(), box.min().y(), box.min().z(), box.max().x(),
                      box.max().y(), box.max().z(), last.x() + 1, last.y() + 1, last.z() + 1))
          .parameter("period");
  }
  return to_python(Value::of(std::move(out)));
}

}  // namespace

void bind_volume_arrays(py::module_& m) {
  using py::arg;
  m.def("volume", volume, arg("array"), arg("voxel_size"), arg("name"));
  m.def("with_period", with_period, arg("volume"), arg("period"));
}

}  // namespace terrazzo::python
