#include "nodes/solids/synthesis/matching/torus_box.h"

namespace terrazzo::solids {
namespace {

// Copies beyond the ends of a closed axis: enough for patches, their neighbors and the filters of the finish.
constexpr int kBeyond = 10;

}  // namespace

TorusBox TorusBox::grown(int by) const {
  TorusBox out = *this;
  for (int a = 0; a < 3; ++a)
    if (!closed[a]) {
      out.lo[a] -= by;
      out.hi[a] += by;
    }
  return out;
}

int first_patch(int voxel, int period) {
  const int turn = floor_divide(voxel, period);
  return turn * patches_around(period) + (wrapped(voxel, period) + 1) / 2;
}

TorusLine::TorusLine(const TorusBox& box, int axis, int whole)
    : period(whole), closed(box.closed[axis]), lo(box.lo[axis]), hi(box.hi[axis]) {
  from = closed ? -kBeyond : lo;
  to = closed ? period + kBeyond : hi;
  first = first_patch(closed ? from : lo - kPatch + 1, period);
  for (int q = first; patch_start(q, period) < to; ++q) start.push_back(patch_start(q, period));
  cover.resize(to - from);
  for (int k = 0; k < patches(); ++k)
    for (int o = 0; o < kPatch; ++o) {
      const int voxel = start[k] + o - from;
      if (voxel < 0 || voxel >= to - from) continue;
      PatchCover& c = cover[voxel];
      c.patch[c.count] = k;
      c.offset[c.count++] = o;
    }
  for (PatchCover& c : cover) c.even = c.count == 4;
}

std::array<int, 2> TorusLine::patches_over(const TorusBox& box, int axis) const {
  if (closed) return {-first, patches_around(period) - first};
  return {first_patch(box.lo[axis] - kPatch + 1, period) - first, first_patch(box.hi[axis], period) - first};
}

TorusLines torus_lines(const TorusBox& box, const Vec3i& level) {
  return {TorusLine(box, 0, level.x()), TorusLine(box, 1, level.y()), TorusLine(box, 2, level.z())};
}

}  // namespace terrazzo::solids
