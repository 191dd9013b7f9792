// Numbers for the materials of a volume: 0 is the binder, then particles or phases. Formats for computation
// want such consecutive numbers, while the grid `id` has gaps and is −1 in the binder.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/particles.h"
#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// What has a number of its own. The values are in the order of the parameter's words.
enum class RegionKind {
  Particles,  // every particle and void with at least one voxel, by ascending index
  Phases,     // every class of particles, and last all voids together
};

struct Region {
  enum class Is { Binder, Particle, Void, Phase };
  Is is = Is::Binder;
  std::int32_t particle = -1;  // its index, or −1
  std::int32_t cls = -1;       // its class, or −1 for the binder, for voids of all classes, or if not known
  std::int32_t phase = 0;      // 0 is the binder, 1 + class a class of particles, then the voids
  std::size_t voxels = 0;

  std::string name() const;  // BINDER, PARTICLE_12, VOID_12, PHASE_1, VOIDS; phases by class
};

struct Regions {
  std::vector<Region> all;                 // by number; [0] is the binder, even where there is none
  std::vector<std::int32_t> of_particle;   // number of each particle at its index; −1 without a voxel
  std::vector<std::int32_t> phase_number;  // phase of each particle at its index

  std::int32_t number(std::int32_t id) const { return id < 0 ? 0 : of_particle[id]; }
  std::int32_t phase(std::int32_t id) const { return id < 0 ? 0 : phase_number[id]; }
};

// `id`: a grid of int32. Without `particles` (null), all particles have phase 1 and none is a void. Throws
// Error "no-id" (the grid is not int32), "missing-input" (Phases without particles), "size-mismatch" (an id
// beyond the particles).
Regions find_regions(const VoxelSource& id, const VoxelBox&, const Particles*, RegionKind, const Work&);

// The regions for which `keep` holds, numbered anew in their order. Voxels of the others get the number 0.
Regions selected_regions(const Regions&, const std::function<bool(const Region&)>& keep);

// One row per region: number, name, kind, particle, class, phase, voxels, volume mm³, fraction, size mm,
// color_r, color_g, color_b (scene-linear). Cells that do not apply are empty text.
Table region_table(const Regions&, const VoxelBox&, const Particles*);

}  // namespace terrazzo::exporting
