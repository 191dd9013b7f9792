// The voxels of a volume as phases, each of which has one value of a property.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/particles.h"
#include "runtime/work.h"

namespace terrazzo::homogenize {

constexpr int kMostPhases = 64;

struct PhaseMap {
  VoxelBox box;
  std::vector<std::uint8_t> phase;  // of each voxel, x fastest
  std::vector<std::string> names;   // of the phases: their numbers, or "binder", "class 0", "void"
  std::vector<double> fraction;     // share of the voxels

  std::size_t count() const { return names.size(); }
};

// Reads one grid: `name`, or if that is empty `phase` (with particles `id`), else `id`, else `density`, else
// the only grid. With particles, the grid contains their indices, and the phases are the binder, the classes
// that occur, in order, and the voids. Without, each whole number is a phase, in increasing order; but if
// `expected` is 2 and the grid contains negative numbers, the phases are the binder (negative) and the
// particles. Coverage and level sets give the phases outside and inside. Throws Error "no-such-grid",
// "several-grids", "not-a-scalar", "too-many-phases", "size-mismatch" (a label that is not a particle),
// "too-large", and those of voxel_box and VoxelSource.
PhaseMap read_phases(const Volume&, const std::string& name, const Particles*, std::size_t expected,
                     std::uint64_t memory, const Work&);

// The same phases with half as many voxels along each axis, each of which takes the phase at a voxel near its
// center. An axis with one voxel stays.
PhaseMap halved(const PhaseMap&, const Work&);

}  // namespace terrazzo::homogenize
