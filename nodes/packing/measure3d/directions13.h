// The 13 directions from a voxel to its 26 neighbors, for Crofton's formulas.
#pragma once

#include <array>
#include <cstddef>

#include "nodes/data/linear.h"

namespace terrazzo::measure3d {

constexpr std::size_t kDirectionCount = 13;
constexpr int kSteps[kDirectionCount][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 0},  {1, -1, 0},
                                            {1, 0, 1},  {-1, 0, 1}, {0, 1, 1},  {0, -1, 1}, {1, 1, 1},
                                            {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}};
constexpr std::size_t kFaceDirections = 3;  // the first ones cross voxel faces

// The step of direction d in mm.
inline Vec3 step_of(std::size_t d, const Vec3& spacing) {
  return Vec3(kSteps[d][0], kSteps[d][1], kSteps[d][2]).cwiseProduct(spacing);
}

// A normal of the planes of voxels h·x = constant, with the direction's numbers as h; its length is 1 / the
// distance of such planes in mm.
inline Vec3 normal_of(std::size_t d, const Vec3& spacing) {
  return Vec3(kSteps[d][0], kSteps[d][1], kSteps[d][2]).cwiseQuotient(spacing);
}

// Share of all directions that are closest to each of 13 lines, given by vectors of any length.
std::array<double, kDirectionCount> direction_shares(const std::array<Vec3, kDirectionCount>& lines);

}  // namespace terrazzo::measure3d
