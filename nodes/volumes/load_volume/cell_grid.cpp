#include "nodes/volumes/load_volume/cell_grid.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/geometry/grid/spaced_transform.h"
#include "nodes/volumes/load_volume/scan.h"

namespace terrazzo::load_volume {
namespace {

template <class T>
double cell_value(const char* at) {
  T v;
  std::memcpy(&v, at, sizeof v);
  return static_cast<double>(v);
}

constexpr CellNumber kSigned[] = {{1, true, cell_value<std::int8_t>},
                                  {2, true, cell_value<std::int16_t>},
                                  {4, true, cell_value<std::int32_t>},
                                  {8, true, cell_value<std::int64_t>}};
constexpr CellNumber kUnsigned[] = {{1, true, cell_value<std::uint8_t>},
                                    {2, true, cell_value<std::uint16_t>},
                                    {4, true, cell_value<std::uint32_t>},
                                    {8, true, cell_value<std::uint64_t>}};
constexpr CellNumber kReal[] = {{4, false, cell_value<float>}, {8, false, cell_value<double>}};

}  // namespace

const CellNumber* cell_number(bool whole, bool is_signed, std::size_t bytes) {
  const auto find = [&](const auto& all) -> const CellNumber* {
    for (const CellNumber& n : all)
      if (n.bytes == bytes) return &n;
    return nullptr;
  };
  return !whole ? find(kReal) : is_signed ? find(kSigned) : find(kUnsigned);
}

CellPlace cell_place(const Vec3i& size, const Vec3& spacing, const Vec3& first, std::optional<Vec3> given,
                     const Reading& reading) {
  CellPlace place;
  place.size = size;
  place.spacing = given.value_or(spacing);
  if (!place.spacing.allFinite() || place.spacing.minCoeff() < kSmallestSpacing)
    throw Error("no-spacing", "the file does not contain the size of its voxels", "set spacing, in mm")
        .parameter("spacing");
  require_representable(place.spacing);
  if (first.allFinite() && first.cwiseAbs().maxCoeff() < (1 << 20))
    place.first = first.array().round().cast<int>();
  if (!first.allFinite() || (first - place.first.cast<double>()).cwiseAbs().maxCoeff() > 1e-3)
    reading.warn("the origin is not a whole number of voxels from 0; the volume is moved to the nearest one");
  return place;
}

void place_volume(Volume& volume, const CellPlace& place) {
  if (volume.periodic()) return;
  volume.first = place.first;
  volume.extent = place.size;
}

std::shared_ptr<openvdb::GridBase> cell_grid(const std::string& name, const CellNumber& scalar,
                                             int components, const std::string& bytes, const CellPlace& place,
                                             int add, const Work& work) {
  const std::size_t step = scalar.bytes * components;
  const auto number = [&](std::size_t voxel, int k = 0) {
    const double v = scalar.read(bytes.data() + voxel * step + k * scalar.bytes) + add;
    if (!std::isfinite(v) || (scalar.whole ? std::abs(v) > 2147483647.0 : std::abs(v) > 3.4e38))
      throw Error("bad-values",
                  fmt::format("array '{}' has the value {} at voxel {}, which a grid cannot hold",
                              printable(name), v, voxel),
                  "replace those voxels");
    return v;
  };
  const auto whole = [&](std::size_t voxel, int k = 0) { return static_cast<int>(number(voxel, k)); };
  const auto real = [&](std::size_t voxel, int k = 0) { return static_cast<float>(number(voxel, k)); };
  const char* text = name.c_str();
  openvdb::GridBase::Ptr grid;
  if (components == 3 && scalar.whole) {
    grid = dense_grid<openvdb::Vec3IGrid>(
        text, place.size, 1, work,
        [&](std::size_t i) { return openvdb::Vec3i(whole(i, 0), whole(i, 1), whole(i, 2)); }, place.first);
  } else if (components == 3) {
    grid = dense_grid<openvdb::Vec3SGrid>(
        text, place.size, 1, work,
        [&](std::size_t i) { return openvdb::Vec3s(real(i, 0), real(i, 1), real(i, 2)); }, place.first);
  } else if (scalar.whole) {
    const auto labels = dense_grid<openvdb::Int32Grid>(
        text, place.size, 1, work, [&](std::size_t i) { return whole(i); }, place.first);
    if (name == "id") mark_binder(*labels);
    grid = labels;
  } else {
    grid = dense_grid<openvdb::FloatGrid>(
        text, place.size, 1, work, [&](std::size_t i) { return real(i); }, place.first);
  }
  grid->setTransform(voxel_transform(place.spacing));
  return grid;
}

}  // namespace terrazzo::load_volume
