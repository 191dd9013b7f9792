// The nearest-neighbor field: the exemplar patch matched to each patch of the solid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/data/linear.h"
#include "nodes/solids/synthesis/exemplar/exemplar_levels.h"

namespace terrazzo::solids {

// All patches of the slices across one axis, oriented as in slice_axes.h. Patch (column i, row j) starts at
// voxel (2i, 2j) of its slice and wraps around; its number is (slice·rows + j)·columns + i.
struct NeighborField {
  int axis = 0, exemplar = 0;
  int slices = 0, columns = 0, rows = 0;
  int width = 0, height = 0;      // voxels of a slice
  std::vector<std::uint32_t> at;  // start of the matched patch: a texel of the exemplar's level
  std::vector<float> weight;      // squared distance after a search, weight after weigh()

  std::size_t count() const { return at.size(); }
};

// A family of random matches.
NeighborField random_matches(const Vec3i& size, int axis, int exemplar, const ExemplarLevel&,
                             std::uint64_t seed);
// For the patches along one axis of slices, the sources on the level below: the patch with the nearest
// center.
struct CarriedPatches {
  std::vector<int> number;   // on the torus
  std::vector<int> from;     // index among the patches below
  std::vector<double> miss;  // distance between the two centers, in voxels of the level below
  int around = 0;            // patches along the torus
};
// For a patch that starts at `start` on an axis of `period` voxels: the number, before wrapping, of its
// source on the level below, where the axis has `below` voxels. Sets `miss` to the distance between the
// centers.
int patch_below(int start, int period, int below, double& miss);
// A slice's two candidate sources below, before wrapping.
std::array<int, 2> slices_below(int slice, int period, int below);
// Carries the matches of `old` up into `f`, which already has its shape. `slices` holds two candidates per
// slice, as indices into the slices of `old`; `number` is each slice's number on the torus.
void carry_matches(const NeighborField& old, const CarriedPatches& columns, const CarriedPatches& rows,
                   const std::vector<std::array<int, 2>>& slices, const std::vector<int>& number,
                   const ExemplarLevel& coarse, const ExemplarLevel& fine, std::uint64_t seed,
                   NeighborField& f, const Work&);
// The same for a whole level: each patch gets the match of the patch at its place, moved to the same place in
// the finer exemplar.
NeighborField carry_up(const NeighborField&, const Vec3i& from, const Vec3i& to, const ExemplarLevel& coarse,
                       const ExemplarLevel& fine, std::uint64_t seed, const Work&);
// Turns squared distances into weights (d² + ε²)^((r − 2)/2), where ε² is their mean; Kwatra et al. 2005 use
// r = 0.8. Without the floor, patches of one plane that match exactly would silence the others. Returns ε².
double weigh(NeighborField&, double exponent, const Work&);

}  // namespace terrazzo::solids
