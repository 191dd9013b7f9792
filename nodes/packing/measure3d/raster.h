// The voxels of a volume as labels, and the phase that is measured.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/indices.h"
#include "nodes/data/particles.h"
#include "runtime/work.h"

namespace terrazzo::measure3d {

// What the phase consists of. The values are in the order of the parameter's words.
enum class Phase { Particles, Voids, Binder };

struct Raster {
  VoxelBox box;
  // Particle of each voxel, x fastest; negative in the binder. Empty if the volume has no whole numbers.
  std::vector<std::int32_t> ids;
  std::vector<std::uint8_t> in;  // 1 where the voxel belongs to the phase
  std::size_t inside = 0;        // voxels in the phase

  std::size_t count() const { return in.size(); }
  std::size_t index(int x, int y, int z) const { return voxel_at(x, y, z, box.size); }
  double fraction() const { return static_cast<double>(inside) / static_cast<double>(count()); }
  double voxel_volume() const { return box.spacing.prod(); }  // mm³
};

// Reads one grid: `name`, or if that is empty `id`, else `density`, else the only grid. Whole numbers are
// labels of particles, of which `particles` tells the voids; those below `threshold`, by default 0, are the
// binder. Other numbers and bools are in particles from `threshold` on, by default 0.5;
// the signed distances of a level set are first converted to coverage, which is 0.5 at the surface. `memory`:
// bytes that the raster may take. Throws Error "no-such-grid", "not-a-scalar", "several-grids",
// "missing-input" (voids without labels), "size-mismatch" (a label that is not a particle), "too-large", and
// those of voxel_box and VoxelSource.
Raster read_raster(const Volume&, const std::string& name, const Particles* particles, Phase phase,
                   std::optional<double> threshold, std::uint64_t memory, const Work&);

}  // namespace terrazzo::measure3d
