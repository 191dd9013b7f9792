// Features of section outlines, invariant to size, position and orientation.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "nodes/common/geometry/mesh/mesh_section.h"

namespace terrazzo {

// In the order of `OutlineFeatures::values`.
enum class OutlineFeature {
  Circularity,     // area / perimeter², at most 1/4π (Jagnow et al. 2008, 4.1)
  TotalCurvature,  // Σ|turning angle| in radians: 2π if convex (Jagnow et al. 2008, 4.1)
  Aspect,          // shorter / longer standard deviation of the area, 0 … 1
  Convexity,       // area / area of the convex hull, 0 … 1
  Corner,          // degrees turned within the 24th of the outline that turns most: 15 for a circle
  Corners,         // number of arcs of a 24th of the outline that turn by 30° or more in either direction
  Symmetry,    // 1 − distance to the best mirror image, as rms of points / rms radius; 1: mirror-symmetric
  Anisotropy,  // of the tangents: difference of the eigenvalues of ∫ t tᵀ ds / length, 0 … 1
  CurvatureLow,  // 10 % quantile of curvature along the outline; 1 is the circle of equal length
  CurvatureMedian,
  CurvatureHigh,  // 90 % quantile
};
inline constexpr std::size_t kOutlineFeatures = 11;
// Column names: "area/perimeter²", "total curvature rad", …
const std::array<std::string, kOutlineFeatures>& outline_feature_names();

struct OutlineFeatures {
  std::array<double, kOutlineFeatures> values{};
  double operator[](OutlineFeature f) const { return values[static_cast<std::size_t>(f)]; }
};

struct OutlineMeasuring {
  // Number of evenly spaced points along the outline at which it is measured, so that the tessellation does
  // not affect the curvature (errata 7, docs/errata.md). 32 … 1024.
  int points = 128;
  double blur = 0;  // standard deviation of a Gaussian blur along the outline before measuring, as a share of
                    // its length, 0 … 0.05
};

// Evenly spaced points along a closed polygon, starting at its first point.
std::vector<Vec2> resampled_loop(const Loop&, int points);

// The median distance of a loop's points if they follow pixels, at even steps; 0 for others, such as sections
// of meshes.
double pixel_step(const Loop&);

// The points at which a loop is measured: evenly spaced, and blurred.
std::vector<Vec2> measured_points(const Loop&, const OutlineMeasuring&);

// Features of a simple counterclockwise loop; all zero if it has no area. outline_features_of: of its
// measured points.
OutlineFeatures outline_features(const Loop&, const OutlineMeasuring& = {});
OutlineFeatures outline_features_of(const std::vector<Vec2>& measured);

// Turning angle over 1/32 of the outline at each of the resampled points, relative to the circle of equal
// length: the distribution of curvature along the outline.
std::vector<double> outline_curvature(const std::vector<Vec2>& resampled);

}  // namespace terrazzo
