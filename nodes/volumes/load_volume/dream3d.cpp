#include "nodes/volumes/load_volume/dream3d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/common/io/hdf5/hdf5_input.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/cell_grid.h"
#include "nodes/volumes/load_volume/stored_numbers.h"

namespace terrazzo::load_volume {
namespace {

constexpr double kMmPerMicrometer = 0.001;

// Three numbers of a dataset or attribute.
Vec3 three_of(const Hdf5Array& array, const std::string& bytes, const char* name) {
  const CellNumber* number =
      cell_number(array.kind != Hdf5Kind::Float, array.kind == Hdf5Kind::Signed, array.bytes);
  if (array.kind == Hdf5Kind::Text || array.kind == Hdf5Kind::Other || !number || array.count() != 3)
    throw Error("unreadable-volume", fmt::format("{} does not consist of three numbers", name));
  return {number->read(bytes.data()), number->read(bytes.data() + array.bytes),
          number->read(bytes.data() + 2 * array.bytes)};
}

struct Dream3dGeometry {
  Vec3i size;
  Vec3 spacing, origin;  // micrometers
  std::optional<Vec3i> period;
};

std::optional<Dream3dGeometry> image_geometry(const Hdf5Input& file, const std::string& container) {
  const std::string path = container + "/_SIMPL_GEOMETRY";
  const auto group = file.find(path);
  if (group == 0 || file.find(path + "/DIMENSIONS") == 0 || file.find(path + "/SPACING") == 0) return {};
  const auto three = [&](const char* name) {
    const auto at = file.find(path + "/" + name);
    if (at == 0) throw Error("unreadable-volume", fmt::format("{} is missing", name));
    const Hdf5Array array = file.array(at);
    if (array.count() != 3)
      throw Error("unreadable-volume", fmt::format("{} does not consist of three numbers", name));
    return three_of(array, file.read(at), name);
  };
  Dream3dGeometry out;
  const Vec3 size = three("DIMENSIONS");
  if (!(size.minCoeff() >= 1) || !(size.maxCoeff() < (1 << 24)) || size.prod() > 2147483647.0)
    throw Error("too-large",
                fmt::format("the volume has {:.0f} × {:.0f} × {:.0f} voxels; 1 to 2^31 are supported",
                            size.x(), size.y(), size.z()));
  out.size = size.array().round().cast<int>();
  out.spacing = three("SPACING");
  out.origin = file.find(path + "/ORIGIN") ? three("ORIGIN") : Vec3::Zero();
  Hdf5Array array;
  std::string bytes;
  if (file.attribute(group, "Period", array, bytes)) {
    const Vec3 period = three_of(array, bytes, "Period");
    if (period == size) out.period = out.size;
  }
  return out;
}

struct Dream3dArray {
  std::string name;
  Hdf5Input::Address at = 0;
  Hdf5Array array;
  int components = 1;
};

// All datasets of the container with one tuple per voxel.
std::vector<Dream3dArray> cell_arrays(const Hdf5Input& file, const std::string& container,
                                      const Dream3dGeometry& geometry, const Reading& reading) {
  std::vector<Dream3dArray> out;
  for (const auto& [matrix, address] : file.children(file.find(container))) {
    if (matrix == "_SIMPL_GEOMETRY" || !file.is_group(address)) continue;
    for (const auto& [name, at] : file.children(address)) {
      if (file.is_group(at)) continue;
      const Hdf5Array array = file.array(at);
      const auto edge = [&](int a) { return static_cast<std::uint64_t>(geometry.size[a]); };
      if (array.size.size() < 3 || array.size.size() > 4 || array.size[0] != edge(2) ||
          array.size[1] != edge(1) || array.size[2] != edge(0))
        continue;
      const std::uint64_t components = array.size.size() == 4 ? array.size[3] : 1;
      if (array.kind == Hdf5Kind::Text || array.kind == Hdf5Kind::Other ||
          (components != 1 && components != 3)) {
        reading.warn(fmt::format("the array '{}' is left out: it does not have one number or three per voxel",
                                 printable(name)));
        continue;
      }
      out.push_back({name, at, array, static_cast<int>(components)});
    }
  }
  return out;
}

// To 7 digits, as floats have them: 250 µm are 0.25 mm.
double to_mm(double micrometers) {
  const double mm = micrometers * kMmPerMicrometer;
  return number_in(fmt::format("{:.7g}", mm)).value_or(mm);
}

Volume read_content(const std::string& content, const std::string& wanted, std::optional<Vec3> spacing,
                    const Reading& reading, const Work& work) {
  const Hdf5Input file(content);
  const auto containers = file.find("/DataContainers");
  if (containers == 0)
    throw Error("not-a-volume", "the HDF5 file has no group DataContainers",
                "write it with DREAM3D 6, file version 7.0");
  std::optional<Dream3dGeometry> geometry;
  std::vector<Dream3dArray> arrays;
  for (const auto& [name, address] : file.children(containers)) {
    if (!file.is_group(address)) continue;
    const std::string path = "/DataContainers/" + name;
    const auto found = image_geometry(file, path);
    if (!found) continue;
    if (geometry && !arrays.empty()) {
      reading.warn(fmt::format("the geometry '{}' is left out: only the first one is read", printable(name)));
      continue;
    }
    geometry = found;
    arrays = cell_arrays(file, path, *found, reading);
  }
  if (!geometry) throw Error("not-a-volume", "the file has no image geometry", "write voxels, not a mesh");
  if (arrays.empty()) throw Error("not-a-volume", "the file has no data of cells");
  const auto has = [&](const std::string& n) {
    return std::any_of(arrays.begin(), arrays.end(), [&](const Dream3dArray& a) { return a.name == n; });
  };
  const bool own = has("id");
  const auto is_wanted = [&](const Dream3dArray& a) {
    if (!wanted.empty()) return a.name == wanted || (wanted == "id" && !own && a.name == "FeatureIds");
    return !own || (a.name != "FeatureIds" && a.name != "Phases");
  };
  const Vec3 mm = geometry->spacing.unaryExpr([](double v) { return to_mm(v); });
  const Vec3 first = geometry->origin.cwiseQuotient(geometry->spacing);
  const CellPlace place = cell_place(geometry->size, mm, first, spacing, reading);
  double needed = content.size();
  for (const Dream3dArray& a : arrays)
    if (is_wanted(a)) needed += a.array.count() * (4 + 2 * static_cast<double>(a.array.bytes));
  require_memory(needed, reading.memory, "the volume");
  Volume volume;
  std::string list;
  for (const Dream3dArray& a : arrays) {
    if (list.size() < 200) list += (list.empty() ? "'" : ", '") + printable(a.name) + "'";
    if (!is_wanted(a)) continue;
    work.check();
    const bool features = a.name == "FeatureIds" && !own && (wanted.empty() || wanted == "id");
    const std::string name = features ? "id" : a.name;
    if (std::any_of(volume.grids.begin(), volume.grids.end(),
                    [&](const auto& g) { return g->getName() == name; })) {
      reading.warn(fmt::format("a second array '{}' is left out", printable(name)));
      continue;
    }
    const CellNumber& number =
        *cell_number(a.array.kind != Hdf5Kind::Float, a.array.kind == Hdf5Kind::Signed, a.array.bytes);
    volume.grids.push_back(
        cell_grid(name, number, a.components, file.read(a.at), place, features ? -1 : 0, work.quiet()));
  }
  if (volume.grids.empty())
    throw Error("no-such-grid",
                fmt::format("the file has no data of cells '{}' (its arrays: {})", wanted, list),
                "name one of them with grid")
        .parameter("grid");
  if (geometry->period && place.first == Vec3i::Zero()) volume.resolution = place.size;
  place_volume(volume, place);
  return volume;
}

}  // namespace

bool is_hdf5(const std::filesystem::path& path) { return Hdf5Input::is_hdf5(read_beginning(path, 8)); }

Volume read_dream3d(const std::filesystem::path& path, const std::string& wanted, std::optional<Vec3> spacing,
                    const Reading& reading, const Work& work) {
  initialize_openvdb();
  const std::string content = read_whole(path, reading);
  try {
    return read_content(content, wanted, spacing, reading, work);
  } catch (const Error& e) {
    if (e.diagnostic().code != "unreadable-volume" && e.diagnostic().code != "not-a-volume") throw;
    throw Error(e.diagnostic().code,
                "'" + path.string() + "' cannot be read as a DREAM3D file: " + e.diagnostic().message,
                e.diagnostic().hint);
  }
}

}  // namespace terrazzo::load_volume
