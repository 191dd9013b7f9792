// Meshes for Abaqus and CalculiX (.inp): one C3D8 element per voxel. The file holds only the mesh, to be read
// with *INCLUDE by a file that adds materials, loads and steps. Lengths in mm, so that stresses are in MPa.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/export/regions.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// Element and node labels have at most nine digits. Throws Error "too-large".
void check_inp(const VoxelBox&);

// Element of voxel (x, y, z): 1 + x + nx·(y + ny·z). Node (i, j, k), 0 to n: 1 + i + (nx + 1)·(j + (ny +
// 1)·k).
//
// Element sets: one per region (Region::name) with at least one voxel; PHASE_CLASS, VOIDS and PARTICLES with
// the sets of particles, of voids and of all particles; ALL_ELEMENTS. Node sets: ALL_NODES; SIDE_X0, SIDE_X1,
// … SIDE_Z1, the six sides with their edges and corners; FACE_X0 … FACE_Z1, without them; EDGE_Y0_Z0 …
// EDGE_X1_Y1, the twelve edges without corners; CORNER_000 … CORNER_111. Opposite faces, and parallel edges,
// list their nodes in the same order, so equal positions are periodic pairs.
//
// `memory`: bytes that may be allocated. `provenance`: JSON for comment lines, or empty. Throws the errors of
// check_inp, Error "too-large", "write-failed".
void write_inp(const std::filesystem::path&, const VoxelSource& id, const VoxelBox&, const Regions&,
               std::uint64_t memory, const std::string& provenance = {}, const Work& = {});

// *EQUATION lines that make the displacements periodic: for a node on a side X1, Y1 or Z1 and its partner on
// the opposite side, u(node) − u(partner) is the sum of u(corner) − u(CORNER_000) over the axes a by which
// they differ, where the corner is the other end of the box's edge along a. So the displacements of
// CORNER_100, CORNER_010 and CORNER_001 prescribe the mean deformation. Throws Error "write-failed".
void write_periodic_inp(const std::filesystem::path&, const VoxelBox&, const Work& = {});

}  // namespace terrazzo::exporting
