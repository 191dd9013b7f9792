// The place of a part of a level, and the margin it needs. A level is a torus. Coordinates of a part continue
// beyond its edges, and each value depends only on its place on the torus, so overlapping parts agree
// wherever they begin.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"
#include "nodes/solids/synthesis/matching/cover.h"

namespace terrazzo::solids {

// Voxels lo … hi − 1. Along a closed axis the box is the whole level, and lo is 0.
struct TorusBox {
  Vec3i lo = Vec3i::Zero(), hi = Vec3i::Zero();
  std::array<bool, 3> closed{};

  Vec3i size() const { return hi - lo; }
  // Grown by `by` voxels on each side of each axis that is not closed.
  TorusBox grown(int by) const;
};

// Patches along an axis of a torus of `period` voxels. Patch q, any integer, starts at patch_start(q). Every
// turn of the torus has (period + 1)/2 patches; if the period is odd, the last is 1 voxel from the next.
inline int floor_divide(int a, int b) { return a / b - (a % b < 0); }
inline int wrapped(int a, int period) { return a - period * floor_divide(a, period); }
inline int patches_around(int period) { return (period + 1) / 2; }
inline int patch_start(int q, int period) {
  return floor_divide(q, patches_around(period)) * period + 2 * wrapped(q, patches_around(period));
}
// The first patch that starts at `voxel` or later.
int first_patch(int voxel, int period);

// The data stored along one axis: voxels from … to − 1 and the patches that cover any of lo … hi − 1. Along a
// closed axis, copies beyond either end are stored too.
struct TorusLine {
  int period = 0;
  bool closed = false;
  int lo = 0, hi = 0, from = 0, to = 0;
  int first = 0;                  // number of the first patch
  std::vector<int> start;         // of each patch
  std::vector<PatchCover> cover;  // of each voxel, counted from `from`; patches are counted from `first`

  TorusLine() = default;
  TorusLine(const TorusBox&, int axis, int period);
  int patches() const { return count_of(start); }
  // The patches that cover any of voxels lo … hi − 1 of a box within this line: the first, and one past the
  // last.
  std::array<int, 2> patches_over(const TorusBox&, int axis) const;
  // The stored index of the original of entry k; k itself if it is an original.
  int original_voxel(int k) const { return closed ? wrapped(from + k, period) - from : k; }
  int original_patch(int k) const { return closed ? wrapped(first + k, patches_around(period)) - first : k; }
};
using TorusLines = std::array<TorusLine, 3>;
TorusLines torus_lines(const TorusBox&, const Vec3i& level);

}  // namespace terrazzo::solids
