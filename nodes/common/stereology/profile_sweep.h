// Areas of the separate profiles of a mesh at all depths along a direction.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/common/stereology/depth_areas.h"

namespace terrazzo {

// One profile over a range of depths; its area excludes its holes.
struct ProfileRange {
  AreaRange area;
  int holes;
};

// Sweeps a closed mesh along directions. Between two consecutive critical vertices (minima, maxima and
// saddles of the height) the loops of the section neither merge nor split, so each loop is the outline of one
// connected piece of the surface: the level sets of the Reeb graph. Ties in height are broken by vertex
// index. Contains scratch memory: use one per thread.
class ProfileSweep {
 public:
  explicit ProfileSweep(const Mesh& mesh);
  // The order is arbitrary but deterministic; valid until the next call.
  const std::vector<ProfileRange>& sweep(const Vec3& direction);

 private:
  struct Loop {               // within a slab between two critical vertices
    double area = 0;          // in the middle of the thickest range; negative for a hole
    std::int32_t owner = -1;  // of a hole: the loop around it
    int holes = 0;
  };
  void start(const Vec3& direction);
  void add_slab(std::int32_t bottom, std::int32_t top);
  void find_loops(std::int32_t bottom, std::int32_t top);
  void add_areas(std::int32_t bottom, std::int32_t top);
  void find_owners(double z);

  const Mesh& mesh_;
  HeightOrder order_;
  double flat_;
  std::vector<Triangle> sides_;             // for each triangle: index of the edge from vertex k to k + 1
  DisjointSets parts_;                      // of edges that one loop crosses, within a slab
  std::vector<std::int32_t> loop_of_edge_;  // for edges that represent a set
  std::vector<RankedTriangle> ranked_;
  std::vector<std::int32_t> by_low_;  // triangles sorted by the rank of their lowest vertex
  std::vector<std::int32_t> bucket_, times_middle_;
  std::size_t next_ = 0;  // index into by_low_
  std::vector<std::int32_t> active_, loop_of_active_;
  std::vector<Loop> loops_;
  std::vector<Quadratic> difference_;  // [loop][range]
  std::vector<AreaRange> areas_;       // [loop][range]
  std::vector<ProfileRange> ranges_;
};

}  // namespace terrazzo
