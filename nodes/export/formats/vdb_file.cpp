#include "nodes/export/formats/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>

#include "nodes/common/geometry/grid/convert_grid.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/data/volume.h"

namespace terrazzo::exporting {
namespace {

// Writes the same bytes as openvdb::io::File to a checked stream, because File ignores write errors.
class StreamArchive : public openvdb::io::Archive {
 public:
  void write_to(std::ostream& out, const openvdb::GridCPtrVec& grids,
                const openvdb::MetaMap& metadata) const {
    write(out, grids, /*seekable=*/true, metadata);
  }

 private:
  using openvdb::io::Archive::write;
};

void check_exact(const openvdb::GridBase& grid, std::int64_t value) {
  constexpr std::int64_t kExact = std::int64_t{1} << 24;  // floats hold every whole number up to here
  if (value > kExact || value < -kExact)
    throw Error("too-many-labels",
                fmt::format("grid '{}' contains {}; numbers beyond 2^24 = {} are not exact as floats",
                            grid.getName(), value, kExact),
                "set id_type: int32")
        .parameter("id_type");
}

openvdb::GridBase::ConstPtr as_floats(const openvdb::GridBase::ConstPtr& grid) {
  openvdb::GridBase::Ptr floats;
  if (const auto* numbers = dynamic_cast<const openvdb::Int32Grid*>(grid.get()))
    floats = convert_grid<openvdb::FloatGrid>(*numbers, [&](std::int32_t v) {
      check_exact(*grid, v);
      return static_cast<float>(v);
    });
  else if (const auto* vectors = dynamic_cast<const openvdb::Vec3IGrid*>(grid.get()))
    floats = convert_grid<openvdb::Vec3SGrid>(*vectors, [&](const openvdb::Vec3i& v) {
      for (int k = 0; k < 3; ++k) check_exact(*grid, v[k]);
      return openvdb::Vec3s(v);
    });
  else
    return grid;
  floats->insertMeta("stored_from", openvdb::StringMetadata(grid->valueType()));
  return floats;
}

}  // namespace

void write_vdb(const std::filesystem::path& path, const Volume& volume, const std::string& provenance,
               WholeNumbers whole_numbers) {
  if (volume.grids.empty()) throw Error("no-grids", "the volume has no grids to write");
  initialize_openvdb();
  openvdb::MetaMap metadata;
  metadata.insertMeta("creator", openvdb::StringMetadata("Terrazzo"));
  if (!provenance.empty()) metadata.insertMeta("provenance", openvdb::StringMetadata(provenance));
  const auto insert = [&](const char* name, const Vec3i& v) {
    metadata.insertMeta(name, openvdb::Vec3IMetadata(openvdb::Vec3i(v.x(), v.y(), v.z())));
  };
  if (volume.periodic()) insert("period", volume.resolution);
  if (volume.has_extent()) {
    insert("extent_min", volume.first);
    insert("extent_max", volume.first + volume.extent - Vec3i::Ones());
  }
  openvdb::GridCPtrVec grids;
  for (const auto& grid : volume.grids)
    grids.push_back(whole_numbers == WholeNumbers::Float ? as_floats(grid) : grid);
  CheckedFile file(path);
  file.guard([&](std::ostream& out) { StreamArchive().write_to(out, grids, metadata); });
}

}  // namespace terrazzo::exporting
