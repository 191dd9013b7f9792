// How much of an outline few straight lines explain.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::shape_estimate {

// Numbers of corners of the inscribed polygons.
inline constexpr std::array<int, 3> kInscribed{3, 4, 6};

// The shares of the area of the points' convex hull that its largest inscribed triangle, quadrilateral and
// hexagon cover: 1 for outlines with straight sides and as many sharp corners or fewer, and 0.413, 0.637 and
// 0.827 for every ellipse. Round corners and bulging sides lower them in proportion to their radius and
// height, but stretching does not change them, and frayed borders do so little, because they are ratios of
// areas. Each polygon is the best of several that no move of one corner improves. 0 without a hull.
std::array<double, kInscribed.size()> inscribed_shares(const std::vector<Vec2>&);

}  // namespace terrazzo::shape_estimate
