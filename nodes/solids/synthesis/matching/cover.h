// The patches over a voxel.
#pragma once

#include <array>
#include <vector>

#include "nodes/solids/synthesis/exemplar/patch_space.h"

namespace terrazzo::solids {

// The patches over a coordinate along one axis: their numbers, and the coordinate's offset in each.
struct PatchCover {
  int count = 0;
  bool even = false;                     // four consecutive patches
  std::array<int, 5> patch{}, offset{};  // 4 entries if the size is even; up to 5 at the wrap of an odd one
};
constexpr int kMostCovering = 84;  // 3 planes of 5 × 5, each rounded up to whole groups of four

inline std::vector<PatchCover> patch_covers(int size) {
  std::vector<PatchCover> out(size);
  for (int p = 0; p < (size + 1) / 2; ++p)
    for (int o = 0; o < kPatch; ++o) {
      PatchCover& c = out[static_cast<std::size_t>((2 * p + o) % size)];
      if (c.count == 5) continue;
      c.patch[c.count] = p;
      c.offset[c.count++] = o;
    }
  for (PatchCover& c : out) c.even = c.count == 4 && c.patch[3] - c.patch[0] == 3;
  return out;
}

}  // namespace terrazzo::solids
