#include "nodes/volumes/load_volume/vti.h"

#include <fmt/format.h>

#include <set>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/cell_grid.h"
#include "nodes/volumes/load_volume/stored_numbers.h"
#include "nodes/volumes/load_volume/vti_layout.h"

namespace terrazzo::load_volume {
namespace {

constexpr double kMmPerMeter = 1000;

struct VtiScalar {
  const char* name;
  bool whole, is_signed;
  std::size_t bytes;
};
constexpr VtiScalar kScalars[] = {{"Int8", true, true, 1},     {"UInt8", true, false, 1},
                                  {"Int16", true, true, 2},    {"UInt16", true, false, 2},
                                  {"Int32", true, true, 4},    {"UInt32", true, false, 4},
                                  {"Int64", true, true, 8},    {"UInt64", true, false, 8},
                                  {"Float32", false, true, 4}, {"Float64", false, true, 8}};

const CellNumber& scalar_of(const VtiArrayText& array) {
  for (const VtiScalar& s : kScalars)
    if (array.type == s.name) return *cell_number(s.whole, s.is_signed, s.bytes);
  throw Error("unreadable-volume",
              fmt::format("array '{}' has the type '{}'", printable(array.name), printable(array.type)),
              "use whole numbers or floats");
}

// To 12 digits: 0.00025 m is 0.25 mm.
double rounded(double v) { return number_in(fmt::format("{:.12g}", v)).value_or(v); }

CellPlace place_of(const VtiLayout& layout, std::optional<Vec3> spacing, const Reading& reading) {
  const Vec3 first = layout.origin.cwiseQuotient(layout.spacing) + layout.start.cast<double>();  // in voxels
  const Vec3 mm = layout.spacing.unaryExpr([](double meters) { return rounded(meters * kMmPerMeter); });
  return cell_place(layout.size, mm, first, spacing, reading);
}

}  // namespace

bool is_vti(const std::filesystem::path& path) {
  return read_beginning(path, 512).find("<VTKFile") != std::string::npos;
}

Volume read_vti(const std::filesystem::path& path, const std::string& wanted, std::optional<Vec3> spacing,
                const Reading& reading, const Work& work) {
  initialize_openvdb();
  const std::string content = read_whole(path, reading);
  try {
    const VtiLayout layout = vti_layout(content, reading);
    const CellPlace place = place_of(layout, spacing, reading);
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
      volume.grids.push_back(cell_grid(a.name, scalar_of(a), a.components, bytes, place, 0, work.quiet()));
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
    place_volume(volume, place);
    return volume;
  } catch (const Error& e) {
    if (e.diagnostic().code != "unreadable-volume" && e.diagnostic().code != "not-a-volume") throw;
    throw Error(e.diagnostic().code,
                "'" + path.string() + "' cannot be read as VTK image data: " + e.diagnostic().message,
                e.diagnostic().hint);
  }
}

}  // namespace terrazzo::load_volume
