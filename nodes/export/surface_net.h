// Surfaces between the regions of a volume, as triangles whose corners lie near those of voxels. All regions
// and the sides of the box share their nodes, so each region is closed, and opposite sides of a volume that
// tiles are equal.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/linear.h"
#include "nodes/export/regions.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// One part of the surfaces: between two pieces, or a piece's part of a side of the box. A piece is a
// connected part of a region within the box: a particle that crosses a side has several.
struct SurfacePatch {
  std::int32_t inside = 0;  // the region with the larger number of two; the normals point away from it
  std::int32_t other = -1;  // the other region, or −1 at a side
  int side = -1;            // 0 to 5: x0, x1, y0, y1, z0, z1; −1 between regions
  std::int32_t inside_piece = 0;
  std::int32_t other_piece =
      -1;  // at a side of a volume that tiles, that on the opposite side; else −1 there
};

struct SurfaceNet {
  std::vector<Vec3> nodes;  // mm
  std::vector<std::array<std::int32_t, 3>>
      corners;                         // of triangles, counterclockwise seen from outside of `inside`
  std::vector<std::int32_t> patch_of;  // of each triangle
  std::vector<SurfacePatch> patches;
  std::vector<std::int32_t> region_of_piece;
  // If the volume tiles: nodes on the sides x1, y1, z1, and their images on x0, y0, z0, in pairs by axis.
  std::array<std::vector<std::pair<std::int32_t, std::int32_t>>, 3> periodic;
};

// The box of a volume that tiles is moved by half a voxel, so that its sides pass through centers of voxels:
// there, opposite sides have equal labels. `smoothing` times, every node moves toward the mean of its
// neighbors on the same surface, line between surfaces or side, and back (Taubin 1995), by less than half of
// a voxel in all along each axis. Corners where lines meet stay, and surfaces never cross or touch anew.
// Throws Error "too-large" if more than `memory` bytes or 2³¹ nodes are needed.
SurfaceNet surface_net(const VoxelSource& id, const VoxelBox&, const Regions&, int smoothing,
                       std::uint64_t memory, const Work&);

}  // namespace terrazzo::exporting
