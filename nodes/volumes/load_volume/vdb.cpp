#include "nodes/volumes/load_volume/vdb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <istream>
#include <optional>
#include <set>
#include <sstream>
#include <streambuf>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "graph/text/utf8.h"
#include "nodes/common/geometry/coverage.h"
#include "nodes/common/geometry/grid/convert_grid.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/vdb_layout.h"

namespace terrazzo::load_volume {
namespace {

Error unreadable(const std::string& what) {
  return Error("unreadable-volume", what, "check that the file is complete");
}

// Part of the file's content as an input stream for OpenVDB. Reading beyond its end throws.
class Bytes : private std::streambuf, public std::istream {
 public:
  Bytes(std::string_view bytes, const VdbHeader& header, std::uint32_t compression)
      : std::istream(static_cast<std::streambuf*>(this)) {
    char* first = const_cast<char*>(bytes.data());
    setg(first, first, first + bytes.size());
    exceptions(std::ios::failbit | std::ios::badbit);
    openvdb::io::setVersion(*this, openvdb::VersionId(header.major, header.minor), header.format);
    openvdb::io::setDataCompression(*this, compression);
  }
};

template <class Grid>
bool all_finite(const openvdb::GridBase& base) {
  const auto* grid = dynamic_cast<const Grid*>(&base);
  if (!grid) return true;
  for (auto it = grid->cbeginValueAll(); it; ++it) {
    const auto v = *it;
    if constexpr (openvdb::VecTraits<std::decay_t<decltype(v)>>::IsVec) {
      if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) return false;
    } else if (!std::isfinite(static_cast<double>(v))) {
      return false;
    }
  }
  return true;
}

// Leaves of bool grids store their own origin in the file.
void check_places(const openvdb::GridBase& base) {
  const auto* grid = dynamic_cast<const openvdb::BoolGrid*>(&base);
  if (!grid) return;
  for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf)
    if (grid->tree().probeConstLeaf(leaf->origin()) != leaf.getLeaf())
      throw unreadable("the leaf origins of grid '" + printable(grid->getName()) + "' do not match its tree");
}

// Metadata about the file, such as its bounding box, is not part of the volume.
void copy_metadata(openvdb::MetaMap& to, const VdbMetadataMap& from) {
  for (const auto& [name, meta] : from) {
    if (name.empty() || name.starts_with("file_") || meta.type.starts_with("__")) continue;
    const std::string type(meta.type);
    if (!openvdb::Metadata::isRegisteredType(type)) continue;
    auto value = openvdb::Metadata::createMetadata(type);
    if (type == openvdb::StringMetadata::staticTypeName())
      static_cast<openvdb::StringMetadata&>(*value).setValue(std::string(meta.bytes));
    else if (value->size() != meta.bytes.size())
      throw unreadable(fmt::format("its metadata entry '{}' has {} bytes instead of {}", printable(name),
                                   meta.bytes.size(), value->size()));
    else {
      std::string sized(sizeof(std::uint32_t), '\0');
      const std::uint32_t size = meta.bytes.size();
      std::memcpy(sized.data(), &size, sizeof size);
      sized += meta.bytes;
      std::istringstream in(sized, std::ios::binary);
      value->read(in);
    }
    to.insertMeta(name, *value);
  }
}

void read_transform(openvdb::GridBase& grid, std::string_view content, const VdbHeader& header,
                    const VdbGrid& g) {
  Bytes in(content.substr(g.transform_at), header, g.compression);
  grid.readTransform(in);
  const auto m = grid.transform().baseMap()->getAffineMap()->getMat4();
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(m.asPointer()[i]))
      throw unreadable("the transform of grid '" + printable(g.name) + "' is not finite");
  if (m.det() == 0) throw unreadable("the transform of grid '" + printable(g.name) + "' is singular");
}

openvdb::GridBase::Ptr read_grid(std::string_view content, const VdbHeader& header, const VdbGrid& g,
                                 const VdbGrid& tree_of) {
  const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(g.type);
  grid->clearMetadata();
  copy_metadata(*grid, g.metadata);
  read_transform(*grid, content, header, g);
  const bool half = grid->saveFloatAsHalf();
  if (half != tree_of.half) grid->setSaveFloatAsHalf(tree_of.half);
  Bytes in(content.substr(tree_of.tree_at), header, tree_of.compression);
  openvdb::io::setGridClass(in, grid->getGridClass());
  grid->readTopology(in);
  grid->readBuffers(in);
  check_places(*grid);
  return grid;
}

bool is_whole(float v) { return v == std::nearbyint(v) && std::abs(v) <= 16777216.0f; }

template <class Grid>
bool all_whole(const Grid& grid) {
  for (auto it = grid.cbeginValueAll(); it; ++it) {
    const auto& v = *it;
    if constexpr (openvdb::VecTraits<std::decay_t<decltype(v)>>::IsVec) {
      if (!is_whole(v[0]) || !is_whole(v[1]) || !is_whole(v[2])) return false;
    } else if (!is_whole(v)) {
      return false;
    }
  }
  return true;
}

// Export stores whole numbers as floats, for programs that read only those, and names their type in the
// metadata `stored_from`. Returns the grid as it was, or the same grid if it was not stored so or no longer
// contains whole numbers, because another program has changed it.
openvdb::GridBase::ConstPtr as_stored_from(const openvdb::GridBase::ConstPtr& grid) {
  const auto type = grid->getMetadata<openvdb::StringMetadata>("stored_from");
  if (!type) return grid;
  openvdb::GridBase::Ptr whole;
  const auto* numbers = dynamic_cast<const openvdb::FloatGrid*>(grid.get());
  const auto* vectors = dynamic_cast<const openvdb::Vec3SGrid*>(grid.get());
  if (numbers && type->value() == "int32" && all_whole(*numbers))
    whole = convert_grid<openvdb::Int32Grid>(*numbers, [](float v) { return static_cast<std::int32_t>(v); });
  else if (vectors && type->value() == "vec3i" && all_whole(*vectors))
    whole =
        convert_grid<openvdb::Vec3IGrid>(*vectors, [](const openvdb::Vec3s& v) { return openvdb::Vec3i(v); });
  else
    return grid;
  whole->removeMeta("stored_from");
  return whole;
}

// The grid that owns the tree of `g`: `g` itself, unless the file stores one tree for several grids.
const VdbGrid& owner_of_tree(const VdbGrid& g, const std::vector<VdbGrid>& all) {
  if (g.parent.empty()) return g;
  for (const VdbGrid& other : all)
    if (other.unique_name == g.parent && other.parent.empty() && other.type == g.type) return other;
  throw unreadable("grid '" + printable(g.name) + "' shares a tree that is missing");
}

std::optional<Vec3i> three_in(const VdbHeader& header, const char* name) {
  const auto it = header.metadata.find(name);
  std::int32_t v[3];
  if (it == header.metadata.end() || it->second.type != openvdb::Vec3IMetadata::staticTypeName() ||
      it->second.bytes.size() != sizeof v)
    return {};
  std::memcpy(v, it->second.bytes.data(), sizeof v);
  return Vec3i(v[0], v[1], v[2]);
}

// The period or the extent that Export wrote into the file's metadata.
void place_volume(Volume& volume, const VdbHeader& header, const Reading& reading) {
  constexpr int kFarthest = 1 << 24;
  if (const auto period = three_in(header, "period"); period && period->minCoeff() > 0) {
    volume.resolution = *period;
    return;
  }
  const auto first = three_in(header, "extent_min"), last = three_in(header, "extent_max");
  if (!first || !last) return;
  const bool possible = (first->array() >= -kFarthest).all() && (last->array() <= kFarthest).all() &&
                        (first->array() <= last->array()).all();
  const openvdb::CoordBBox voxels = voxels_of(volume);
  const openvdb::CoordBBox extent(openvdb::Coord(first->x(), first->y(), first->z()),
                                  openvdb::Coord(last->x(), last->y(), last->z()));
  if (!possible || (!voxels.empty() && !extent.isInside(voxels))) {
    reading.warn("the file's extent_min and extent_max do not contain its voxels, so they are ignored");
    return;
  }
  volume.first = *first;
  volume.extent = *last - *first + Vec3i::Ones();
}

// Whether a grid of unknown class has the form of a level set: a narrow band of distances between inactive
// values of one size, negative inside and positive outside.
template <class Grid>
bool has_form_of_level_set(const openvdb::GridBase& base) {
  const auto* grid = dynamic_cast<const Grid*>(&base);
  if (!grid || base.getGridClass() != openvdb::GRID_UNKNOWN || !(grid->background() > 0)) return false;
  const auto band = grid->background();
  bool inside = false;
  for (auto it = grid->cbeginValueAll(); it; ++it) {
    if (std::abs(*it) > band || (!it.isValueOn() && std::abs(*it) != band)) return false;
    inside = inside || (!it.isValueOn() && *it < 0);
  }
  return inside;
}

// Signed distances under the name of a density, which other nodes take for coverage, become coverage.
openvdb::GridBase::ConstPtr as_density(const openvdb::GridBase::ConstPtr& grid, const Reading& reading) {
  const auto* distances = dynamic_cast<const openvdb::FloatGrid*>(grid.get());
  if (!distances || grid->getName() != "density") return grid;
  reading.warn("the grid density is a level set; it is converted to coverage, from 0 outside to 1 inside");
  return coverage_of(*distances);
}

// Marks level sets whose class the file does not name, and gives the grid `density` the values of its name.
void settle_level_sets(Volume& volume, const Reading& reading) {
  const openvdb::CoordBBox voxels = voxels_of(volume);
  for (auto& grid : volume.grids) {
    if (has_form_of_level_set<openvdb::FloatGrid>(*grid) ||
        has_form_of_level_set<openvdb::DoubleGrid>(*grid)) {
      const auto marked = grid->deepCopyGrid();
      marked->setGridClass(openvdb::GRID_LEVEL_SET);
      reading.warn(
          fmt::format("grid '{}' has the form of a level set and is read as one: signed distances in mm",
                      printable(grid->getName())));
      grid = marked;
    }
    if (grid->getGridClass() != openvdb::GRID_LEVEL_SET) continue;
    const auto density = as_density(grid, reading);
    if (density == grid) continue;
    grid = density;
    if (volume.periodic() || volume.has_extent() || voxels.empty()) continue;
    // The band outside the surface, which is no longer active, stays a part of the volume.
    volume.first = Vec3i(voxels.min().x(), voxels.min().y(), voxels.min().z());
    volume.extent = Vec3i(voxels.dim().x(), voxels.dim().y(), voxels.dim().z());
  }
}

Volume read_content(std::string_view content, const std::string& wanted, const std::filesystem::path& path,
                    const Reading& reading, std::vector<std::string>& names) {
  const VdbHeader header = read_vdb_header(content);
  const std::vector<VdbGrid> grids = vdb_grids(content, header);
  Volume volume;
  double needed = content.size();
  // Grids that may be converted exist twice for a moment.
  const auto copied = [](const VdbGrid& g) {
    return g.metadata.count("stored_from") || g.name == "density" || !g.metadata.count("class");
  };
  const auto is_wanted = [&](const VdbGrid& g) {
    return g.known && (wanted.empty() || g.name == wanted || g.unique_name == wanted);
  };
  for (const VdbGrid& g : grids)
    if (is_wanted(g)) needed += owner_of_tree(g, grids).memory * (copied(g) ? 2 : 1);
  require_memory(needed, reading.memory, "the volume in '" + path.string() + "'");
  for (const VdbGrid& g : grids) {
    names.push_back(g.name);
    if (is_wanted(g)) volume.grids.push_back(read_grid(content, header, g, owner_of_tree(g, grids)));
  }
  place_volume(volume, header, reading);
  return volume;
}

}  // namespace

bool is_vdb(const std::filesystem::path& path) { return read_beginning(path, 4) == " BDV"; }

Volume read_vdb(const std::filesystem::path& path, const std::string& wanted, const Reading& reading) {
  initialize_openvdb();
  Volume volume;
  std::vector<std::string> names;
  const std::string content = read_whole(path, reading);
  const auto cannot = [&](const std::string& why, const std::string& hint) {
    return Error("unreadable-volume", "'" + path.string() + "' cannot be read as OpenVDB: " + why, hint);
  };
  try {
    volume = read_content(content, wanted, path, reading, names);
  } catch (const Error& e) {
    if (e.diagnostic().code != "unreadable-volume") throw;
    throw cannot(e.diagnostic().message, e.diagnostic().hint);
  } catch (const std::exception& e) {
    throw cannot(printable(e.what()), "check that the file is complete");
  }
  std::set<std::string> taken;
  for (const auto& g : volume.grids) {
    const std::string name = printable(g->getName());
    if (!taken.insert(g->getName()).second)
      throw Error("unreadable-volume", "'" + path.string() + "' has two grids named '" + name + "'");
    if (!all_finite<openvdb::FloatGrid>(*g) || !all_finite<openvdb::DoubleGrid>(*g) ||
        !all_finite<openvdb::Vec3SGrid>(*g))
      throw Error("bad-values", "grid '" + name + "' of '" + path.string() + "' contains NaN or infinity",
                  "replace those voxels");
  }
  for (auto& g : volume.grids) g = as_stored_from(g);
  settle_level_sets(volume, reading);
  if (volume.grids.empty()) {
    std::string list;
    for (const auto& n : names)
      if (list.size() < 200) list += (list.empty() ? "'" : ", '") + printable(n) + "'";
    throw Error("no-such-grid",
                fmt::format("'{}' has no usable grid {}(its grids: {})", path.string(),
                            wanted.empty() ? "" : "'" + wanted + "' ", list.empty() ? "none" : list),
                "use a grid of type float, double, vec3s, int32 or bool")
        .parameter("grid");
  }
  return volume;
}

std::vector<std::string> make_names_valid(Volume& volume) {
  std::vector<std::string> warnings;
  std::set<std::string> names;
  for (const auto& grid : volume.grids) {
    const std::string name = valid_utf8(grid->getName());
    if (name != grid->getName()) {
      warnings.push_back("a grid name is not UTF-8: the grid is renamed " + name);
      std::const_pointer_cast<openvdb::GridBase>(grid)->setName(name);  // no one else holds the grid yet
    }
    if (!names.insert(name).second)
      throw Error("unreadable-volume", "two grids are named '" + name + "'", "give each grid a unique name")
          .parameter("path");
  }
  return warnings;
}

}  // namespace terrazzo::load_volume
