#include "nodes/export/vdb_file.h"

#include <openvdb/io/Archive.h>

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

}  // namespace

void write_vdb(const std::filesystem::path& path, const Volume& volume, const std::string& provenance) {
  if (volume.grids.empty()) throw Error("no-grids", "the volume has no grids to write");
  initialize_openvdb();
  openvdb::MetaMap metadata;
  metadata.insertMeta("creator", openvdb::StringMetadata("Terrazzo"));
  if (!provenance.empty()) metadata.insertMeta("provenance", openvdb::StringMetadata(provenance));
  if (volume.resolution.minCoeff() > 0)
    metadata.insertMeta("period", openvdb::Vec3IMetadata(openvdb::Vec3i(
                                      volume.resolution.x(), volume.resolution.y(), volume.resolution.z())));
  const openvdb::GridCPtrVec grids(volume.grids.begin(), volume.grids.end());
  CheckedFile file(path);
  file.guard([&](std::ostream& out) { StreamArchive().write_to(out, grids, metadata); });
}

}  // namespace terrazzo::exporting
