#include "nodes/solids/patch_fill/read_solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "graph/diagnostic.h"

namespace terrazzo::patch_fill {

VoxelBox solid_box(const Volume& volume, const std::string& input) {
  constexpr int kLeast = 16;  // two patches
  const VoxelBox box = voxel_box(volume);
  if (!box.periodic)
    throw Error("not-periodic", fmt::format("the solid at input {} does not tile", input),
                "connect a solid that tiles, for example from SolidOptimize");
  if (box.size.minCoeff() < kLeast)
    throw Error("too-small",
                fmt::format("the solid at input {} has {} × {} × {} voxels", input, box.size.x(),
                            box.size.y(), box.size.z()),
                fmt::format("use a solid of at least {0} × {0} × {0} voxels", kLeast));
  return box;
}

Torus<Vec3f> read_solid(const Volume& volume, const VoxelBox& box, const std::string& input) {
  const auto names = grid_names(volume);
  std::optional<VoxelSource> source;
  if (std::find(names.begin(), names.end(), "Cd") != names.end()) source.emplace(volume, "Cd", box);
  if (!source || source->components() != 3)
    throw Error("no-color", fmt::format("the solid at input {} has no color grid 'Cd'", input),
                "connect a solid texture, for example from SolidOptimize");
  Torus<Vec3f> out(box.size, Vec3f::Zero());
  source->read(0, box.size.z(), out.at.data());
  return out;
}

}  // namespace terrazzo::patch_fill
