#include "nodes/load_volume/vti.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/dense_grid.h"
#include "nodes/common/geometry/spaced_transform.h"
#include "nodes/load_volume/scan.h"
#include "nodes/load_volume/vti_layout.h"

namespace terrazzo::load_volume {
namespace {

constexpr double kMmPerMeter = 1000;

template <class T>
double vti_number(const char* at) {
  T v;
  std::memcpy(&v, at, sizeof v);
  return static_cast<double>(v);
}

using VtiNumber = double (*)(const char*);
struct VtiScalar {
  const char* name;
  std::size_t bytes;
  bool whole;
  VtiNumber number;
};
constexpr VtiScalar kScalars[] = {
    {"Int8", 1, true, vti_number<std::int8_t>},   {"UInt8", 1, true, vti_number<std::uint8_t>},
    {"Int16", 2, true, vti_number<std::int16_t>}, {"UInt16", 2, true, vti_number<std::uint16_t>},
    {"Int32", 4, true, vti_number<std::int32_t>}, {"UInt32", 4, true, vti_number<std::uint32_t>},
    {"Int64", 8, true, vti_number<std::int64_t>}, {"UInt64", 8, true, vti_number<std::uint64_t>},
    {"Float32", 4, false, vti_number<float>},     {"Float64", 8, false, vti_number<double>}};

const VtiScalar& scalar_of(const VtiArrayText& array) {
  for (const VtiScalar& s : kScalars)
    if (array.type == s.name) return s;
  throw Error("unreadable-volume",
              fmt::format("array '{}' has the type '{}'", printable(array.name), printable(array.type)),
              "use whole numbers or floats");
}

struct VtiPlace {
  Vec3i size, first;
  Vec3 spacing;
};

openvdb::GridBase::Ptr grid_of(const VtiArrayText& array, const std::string& bytes, const VtiPlace& place,
                               const Work& work) {
  const VtiScalar& scalar = scalar_of(array);
  const std::size_t step = scalar.bytes * static_cast<std::size_t>(array.components);
  const auto number = [&](std::size_t voxel, int k = 0) {
    const double v = scalar.number(bytes.data() + voxel * step + static_cast<std::size_t>(k) * scalar.bytes);
    if (!std::isfinite(v) || (scalar.whole ? std::abs(v) > 2147483647.0 : std::abs(v) > 3.4e38))
      throw Error("bad-values",
                  fmt::format("array '{}' has the value {} at voxel {}, which a grid cannot hold",
                              printable(array.name), v, voxel),
                  "replace those voxels");
    return v;
  };
  const char* name = array.name.c_str();
  openvdb::GridBase::Ptr grid;
  if (array.components == 3 && scalar.whole)
    grid = dense_grid<openvdb::Vec3IGrid>(
        name, place.size, 1, work,
        [&](std::size_t i) {
          return openvdb::Vec3i(static_cast<int>(number(i, 0)), static_cast<int>(number(i, 1)),
                                static_cast<int>(number(i, 2)));
        },
        place.first);
  else if (array.components == 3)
    grid = dense_grid<openvdb::Vec3SGrid>(
        name, place.size, 1, work,
        [&](std::size_t i) {
          return openvdb::Vec3s(static_cast<float>(number(i, 0)), static_cast<float>(number(i, 1)),
                                static_cast<float>(number(i, 2)));
        },
        place.first);
  else if (scalar.whole) {
    const auto whole = dense_grid<openvdb::Int32Grid>(
        name, place.size, 1, work, [&](std::size_t i) { return static_cast<int>(number(i)); }, place.first);
    if (array.name == "id") mark_binder(*whole);
    grid = whole;
  } else {
    grid = dense_grid<openvdb::FloatGrid>(
        name, place.size, 1, work, [&](std::size_t i) { return static_cast<float>(number(i)); }, place.first);
  }
  grid->setTransform(voxel_transform(place.spacing));
  return grid;
}

// To 12 digits: 0.00025 m is 0.25 mm.
double rounded(double v) { return std::strtod(fmt::format("{:.12g}", v).c_str(), nullptr); }

VtiPlace place_of(const VtiLayout& layout, std::optional<Vec3> spacing, const Reading& reading) {
  VtiPlace place;
  place.size = layout.size;
  for (int k = 0; k < 3; ++k)
    place.spacing[k] = spacing ? (*spacing)[k] : rounded(layout.spacing[k] * kMmPerMeter);
  if (!place.spacing.allFinite() || place.spacing.minCoeff() < kSmallestSpacing)
    throw Error("no-spacing", "the file does not contain the size of its voxels", "set spacing, in mm")
        .parameter("spacing");
  const Vec3 first = layout.origin.cwiseQuotient(layout.spacing) + layout.start.cast<double>();  // in voxels
  place.first = Vec3i::Zero();
  if (first.allFinite() && first.cwiseAbs().maxCoeff() < (1 << 20))
    place.first = first.array().round().cast<int>();
  if (!first.allFinite() || (first - place.first.cast<double>()).cwiseAbs().maxCoeff() > 1e-3)
    reading.warn("the origin is not a whole number of voxels from 0; the volume is moved to the nearest one");
  return place;
}

}  // namespace

bool is_vti(const std::filesystem::path& path) {
  std::string head(512, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.find("<VTKFile") != std::string::npos;
}

Volume read_vti(const std::filesystem::path& path, const std::string& wanted, std::optional<Vec3> spacing,
                const Reading& reading, const Work& work) {
  initialize_openvdb();
  const std::string content = read_whole(path, reading);
  try {
    const VtiLayout layout = vti_layout(content, reading);
    const VtiPlace place = place_of(layout, spacing, reading);
    std::set<std::string> names;
    for (const auto& a : layout.cells)
      if (!names.insert(a.name).second)
        throw Error("unreadable-volume", "two arrays are named '" + printable(a.name) + "'");
    const auto is_wanted = [&](const VtiArrayText& a) {
      if (!wanted.empty()) return a.name == wanted;
      return !names.count("id") || (a.name != "material" && a.name != "phase");
    };
    Volume volume;
    const double voxels = place.size.cast<double>().prod();
    double needed = double(content.size());
    for (const auto& a : layout.cells)
      if (is_wanted(a)) needed += voxels * a.components * (4 + double(scalar_of(a).bytes));
    require_memory(needed, reading.memory, "the volume in '" + path.string() + "'");
    for (const auto& a : layout.cells) {
      if (!is_wanted(a)) continue;
      work.check();
      const std::string bytes =
          vti_bytes(content, layout, a, scalar_of(a).bytes, static_cast<std::size_t>(voxels) * a.components);
      volume.grids.push_back(grid_of(a, bytes, place, work.quiet()));
    }
    if (volume.grids.empty()) {
      std::string list;
      for (const auto& n : names)
        if (list.size() < 200) list += (list.empty() ? "'" : ", '") + printable(n) + "'";
      throw Error("no-such-grid",
                  fmt::format("'{}' has no cell data {}(its arrays: {})", path.string(),
                              wanted.empty() ? "" : "'" + wanted + "' ", list.empty() ? "none" : list),
                  "name one of them with grid")
          .parameter("grid");
    }
    if (layout.period == place.size && place.first == Vec3i::Zero()) volume.resolution = place.size;
    return volume;
  } catch (const Error& e) {
    if (e.diagnostic().code != "unreadable-volume" && e.diagnostic().code != "not-a-volume") throw;
    throw Error(e.diagnostic().code,
                "'" + path.string() + "' cannot be read as VTK image data: " + e.diagnostic().message,
                e.diagnostic().hint);
  }
}

}  // namespace terrazzo::load_volume
