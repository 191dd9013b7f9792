// Which exemplar patch each patch of the solid is matched to.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "nodes/common/slice_axes.h"
#include "nodes/solid_optimize/exemplar_levels.h"

namespace terrazzo::solid_optimize {

// All patches of the slices across one axis, seen as in slice_axes.h. Patch (column i, row j) starts at voxel
// (2i, 2j) of its slice and wraps around; its number is (slice·rows + j)·columns + i.
struct MatchFamily {
  int axis = 0, exemplar = 0;
  int slices = 0, columns = 0, rows = 0;
  int width = 0, height = 0;      // voxels of a slice
  std::vector<std::uint32_t> at;  // start of the matched patch, a texel of the exemplar's level
  std::vector<float> weight;      // squared distance after a search, weight once weighed

  std::size_t count() const { return at.size(); }
};

// A family of random matches.
MatchFamily random_matches(const Vec3i& size, int axis, int exemplar, const ExemplarLevel&,
                           std::uint64_t seed);
// Where the patches along one axis of slices come from, one level up: each from the one whose centre is
// nearest.
struct CarriedPatches {
  std::vector<int> number;   // on the torus
  std::vector<int> from;     // index among the patches below
  std::vector<double> miss;  // voxels below by which its centre lies off
  int around = 0;            // patches along the torus
};
// A patch that starts at `start` of an axis of `period` voxels: the number of the patch below, where the axis
// has `below` voxels, before any wrapping, and by how much it misses.
int patch_below(int start, int period, int below, double& miss);
// A slice's two candidates below, before any wrapping.
std::array<int, 2> slices_below(int slice, int period, int below);
// The matches of `old` in the places told, into `f`, which has its shape already: `slices` are the two
// candidates of each, indices among those of `old`; `number` of each slice is that on the torus.
void carry_matches(const MatchFamily& old, const CarriedPatches& columns, const CarriedPatches& rows,
                   const std::vector<std::array<int, 2>>& slices, const std::vector<int>& number,
                   const ExemplarLevel& coarse, const ExemplarLevel& fine, std::uint64_t seed, MatchFamily& f,
                   const Work&);
// The same matches one level up: each patch takes what stood at its place, at its exemplar's place.
MatchFamily carry_up(const MatchFamily&, const Vec3i& from, const Vec3i& to, const ExemplarLevel& coarse,
                     const ExemplarLevel& fine, std::uint64_t seed, const Work&);
// Squared distances become weights (d² + ε²)^((r − 2)/2), ε² being their mean: r = 0.8 in Kwatra et al. 2005.
// Without the floor the patches of one plane that match exactly silence the others. Returns ε².
double weigh(MatchFamily&, double exponent, const Work&);

}  // namespace terrazzo::solid_optimize
