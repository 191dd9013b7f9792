#include "nodes/load_volume/vdb.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>

#include "graph/diagnostic.h"

namespace terrazzo::load_volume {
namespace {

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

bool known_type(const openvdb::GridBase& g) {
  return g.isType<openvdb::FloatGrid>() || g.isType<openvdb::DoubleGrid>() ||
         g.isType<openvdb::Vec3SGrid>() || g.isType<openvdb::Int32Grid>() || g.isType<openvdb::BoolGrid>();
}

}  // namespace

bool is_vdb(const std::filesystem::path& path) {
  char head[4] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  return std::memcmp(head, " BDV", 4) == 0;
}

Volume read_vdb(const std::filesystem::path& path, const std::string& wanted) {
  initialize_openvdb();
  Volume volume;
  std::vector<std::string> names;
  try {
    openvdb::io::File file(path.string());
    file.setCopyMaxBytes(0);  // no delayed loading: the file may change
    file.open(/*delayLoad=*/false);
    for (auto it = file.beginName(); it != file.endName(); ++it) {
      names.push_back(it.gridName());
      if (!wanted.empty() && it.gridName() != wanted) continue;
      const openvdb::GridBase::Ptr grid = file.readGrid(it.gridName());
      if (known_type(*grid)) volume.grids.push_back(grid);
    }
    if (const auto meta = file.getMetadata()) {
      if (const auto period = meta->getMetadata<openvdb::Vec3IMetadata>("period")) {
        const openvdb::Vec3i p = period->value();
        if (p[0] > 0 && p[1] > 0 && p[2] > 0) volume.resolution = Vec3i(p[0], p[1], p[2]);
      }
    }
  } catch (const std::exception& e) {
    throw Error("unreadable-volume", "'" + path.string() + "' cannot be read as OpenVDB: " + e.what(),
                "check that the file is whole");
  }
  std::set<std::string> taken;
  for (const auto& g : volume.grids) {
    if (!taken.insert(g->getName()).second)
      throw Error("unreadable-volume", "'" + path.string() + "' has two grids named '" + g->getName() + "'");
    if (!g->transform().isLinear())
      throw Error("unreadable-volume", "grid '" + g->getName() + "' of '" + path.string() + "' is a frustum",
                  "resample it to equal voxels");
    if (!all_finite<openvdb::FloatGrid>(*g) || !all_finite<openvdb::DoubleGrid>(*g) ||
        !all_finite<openvdb::Vec3SGrid>(*g))
      throw Error("bad-values",
                  "grid '" + g->getName() + "' of '" + path.string() + "' holds NaN or infinity",
                  "replace those voxels");
  }
  if (volume.grids.empty()) {
    std::string list;
    for (const auto& n : names) list += (list.empty() ? "'" : ", '") + n + "'";
    throw Error("no-such-grid",
                fmt::format("'{}' has no grid {}that can be used; it has {}", path.string(),
                            wanted.empty() ? "" : "'" + wanted + "' ", list.empty() ? "none" : list),
                "name a grid of floats, doubles, vectors, whole numbers or truth values")
        .parameter("grid");
  }
  return volume;
}

}  // namespace terrazzo::load_volume
