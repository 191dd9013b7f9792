// Fills voxels of a solid with what two solids have.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/solids/patch_fill/torus.h"
#include "runtime/work.h"

namespace terrazzo::patch_fill {

// All arrays have one size, at least 16 voxels along each axis, and tile. Colors are scene-linear.
struct FillProblem {
  Torus<Vec3f> a, b;
  Torus<float> weight;  // share of b, 0 to 1
  Torus<Vec3f> known;   // colors of the voxels that are not free
  Torus<float> free;    // 1 where a voxel is to be filled, 0 where it is known
  // Where patches of a and b may come from. Anywhere: known voxels of weight 0 and 1 are those of a and b at
  // the same places, so the rest continues them there. Guided: those of b from their own place only, so that
  // b shows where its weight is large; those of a from places at least 1/kApart of the shortest edge away,
  // since a near its own place would be restored.
  enum class Sources { Anywhere, Guided } sources = Sources::Anywhere;
  static constexpr int kApart = 5;
  // Whether the result tiles. Otherwise no patch reaches beyond its borders, at which no voxel may be free.
  bool tiles = true;
};

struct FillOptions {
  std::vector<int> iterations = {30, 8};  // per level, coarsest first; the last one repeats
  double exponent = 0.8;                  // r of ‖·‖^r
  double window = 0.02;  // of the mean shift at the end of each level; it starts ten times as wide
  double overuse = 1;    // penalty on patches used more often than average
  std::uint64_t seed = 1;
};

struct FillResult {
  Torus<Vec3f> color;  // scene-linear; known voxels are unchanged, bit for bit
  int levels = 1;
  std::size_t filled = 0;  // voxels
};

// Every patch over a free voxel gets a match in each solid that has a share of it. Throws Error "one-color".
FillResult fill(const FillProblem&, const FillOptions&, const Work&);

// Peak memory in bytes, including the arrays of the problem.
double fill_memory(const Vec3i& size);

}  // namespace terrazzo::patch_fill
