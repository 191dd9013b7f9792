// What tells outlines of sections apart: measures that size, place and orientation do not change.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "nodes/common/mesh_section.h"

namespace terrazzo {

// In the order of `OutlineFeatures::values`.
enum class OutlineFeature {
  Circularity,     // area / perimeter², at most 1/4π (Jagnow et al. 2008, 4.1)
  TotalCurvature,  // Σ|turn|, radians: 2π where convex (the same)
  Aspect,          // shorter / longer standard deviation of the area, 0…1
  Convexity,       // area / area of the convex hull, 0…1
  Corner,          // degrees turned within the 24th of the outline that turns most: 15 of a circle
  Corners,         // arcs of a 24th of the outline that turn by 30° or more, either way
  Symmetry,        // 1 less the distance to the mirror image at best, rms of points over rms radius; 1:
                   // mirror-symmetric
  Anisotropy,      // of the tangents: difference of the eigenvalues of ∫ t tᵀ ds / length, 0…1
  CurvatureLow,    // 10 % quantile of curvature along the outline, in units of the circle of equal length (1)
  CurvatureMedian,
  CurvatureHigh,  // 90 %
};
inline constexpr std::size_t kOutlineFeatures = 11;
// As in tables: "area/perimeter²", "total curvature rad", …
const std::array<std::string, kOutlineFeatures>& outline_feature_names();

struct OutlineFeatures {
  std::array<double, kOutlineFeatures> values{};
  double operator[](OutlineFeature f) const { return values[static_cast<std::size_t>(f)]; }
};

struct OutlineMeasuring {
  // Points of equal distance along the outline at which it is measured: tessellation then neither adds
  // curvature nor takes it (ERRATA of the paper). 32…1024.
  int points = 128;
  double blur =
      0;  // standard deviation of a Gaussian along the outline first, as a share of its length, 0…0.05
};

// Points of equal distance along a closed polygon, from its first point on.
std::vector<Vec2> resampled_loop(const Loop&, int points);

// Of a simple loop, counter-clockwise; nothing but zeros where it has no area.
OutlineFeatures outline_features(const Loop&, const OutlineMeasuring& = {});

// Turns over 1/32 of the outline at each of `points` points, in units of the circle's of equal length: the
// distribution of curvature along the outline.
std::vector<double> outline_curvature(const std::vector<Vec2>& resampled);

}  // namespace terrazzo
