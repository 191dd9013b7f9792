// Dense lattice planes into which particles are stamped before conversion to sparse grids.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/volumes/voxelize/lattice.h"
#include "nodes/volumes/voxelize/mesh_sdf.h"
#include "nodes/volumes/voxelize/scan.h"

namespace terrazzo::voxelize {

// Half-width of the level set's narrow band in voxels; OpenVDB's default.
constexpr double kBand = 3;

struct Slab {
  struct Share {
    std::uint32_t cell;  // in its plane
    std::int32_t particle;
    float cover;
  };
  static constexpr std::int32_t kNone = -1, kSeveral = -2;

  int z0 = 0, z1 = 0;  // planes [z0, z1)
  Vec3i lattice = Vec3i::Zero();
  std::vector<float> coverage;             // sum over solid particles; may exceed 1
  std::vector<std::int32_t> owner;         // the solid particle that covers, or kNone, or kSeveral
  std::vector<std::vector<Share>> shares;  // by plane, of kSeveral, in the order of their sums
  std::vector<float> distance;             // voxels, within ±kBand
  std::vector<std::int32_t> id;            // −1 outside
  std::vector<float> holes;                // sum over voids; empty if there are none
  Slab(const Vec3i& lattice, int z0, int z1, bool has_voids);
  std::size_t bytes() const;
  std::size_t index(int i, int j, int k) const {  // k is relative to z0
    return voxel_at(i, j, k, lattice);
  }
};

// Contribution of one particle, or of its part within one period of the slab.
struct Stamp {
  std::int32_t particle = 0;
  CellBox box;  // lattice cells, not yet wrapped
  Scan scan;
  std::vector<float> distance;
};

// Fills the scan of the stamp.
void scan_stamp(Stamp&, const Particles&, const Shape&, double voxel);

// Marks the cells of the slab inside a solid particle, after scan_stamp. `taken` has the cells of
// Slab::index.
void mark_inside(const Slab&, const std::vector<Stamp>&, const Particles&, std::vector<std::uint8_t>& taken,
                 const Work&);

// Fills the distances of a solid particle's stamp, except in cells inside other particles, where they do not
// count: there they are kBand. `sdf` uses the unit of the shape's mesh; without one (null), distances are
// computed from the triangles.
void add_distances(Stamp&, const Slab&, const std::vector<std::uint8_t>& taken, const Particles&,
                   const Shape&, const MeshSdf* sdf, double voxel);

// Adds the stamps in order, independent of the number of threads. Reads no colors.
void add_stamps(Slab&, const std::vector<Stamp>&, const Particles&, const Work&);

// The sums of coverage · color in plane k of the slab.
void add_colors(const Slab&, std::size_t k, const Particles&, Vec3f* colors);

}  // namespace terrazzo::voxelize
