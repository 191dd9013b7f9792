// Pairs of nearby balls in a periodic box, for any mixture of sizes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::packing {

struct Pair {
  std::int32_t a, b;                 // a < b
  std::array<std::int8_t, 3> image;  // b's center is position[b] + image · box
};

// All pairs of balls at a distance of less than `reach`. Images are separate entries, because two particles
// may be close through two faces of a small box. Positions in [0, box). Uses a hierarchical grid: each
// octave of size has cells as large as its largest ball, and a ball searches its own and all coarser levels
// (Ericson 2005, section 7.2). The order does not depend on the number of threads. Every ball must be
// smaller than the box.
std::vector<Pair> near_pairs(const Vec3& box, const std::vector<Vec3>& position,
                             const std::vector<double>& radius, double reach, const Work& work = {});

// The pairs of each particle: entries 2 · pair + side (0 if the particle is `a`), in the order of the pairs.
struct Incidence {
  std::vector<std::int32_t> begin;  // n + 1
  std::vector<std::int32_t> entry;
};
Incidence incidence_of(std::size_t n, const std::vector<Pair>& pairs);

inline Vec3 offset_of(const Pair& p, const Vec3& box, const std::vector<Vec3>& position) {
  return position[p.b] - position[p.a] + Vec3(p.image[0] * box[0], p.image[1] * box[1], p.image[2] * box[2]);
}

}  // namespace terrazzo::packing
