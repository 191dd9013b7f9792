// The three silhouettes from which constructive solid geometry creates a body (Jagnow et
// al. 2008, section 3.2).
#pragma once

#include <array>
#include <vector>

#include "nodes/shapes/shape_estimate/methods/extrusions.h"
#include "nodes/shapes/shape_estimate/outline.h"

namespace terrazzo::shape_estimate {

// Three profiles by decreasing aspect ratio (or in another of six `order`s), scaled to bounding boxes a × b,
// b × c and a × c, where a and b are those of the first profile and c preserves the aspect ratio of the
// third. Returned as polygons of (x₀, x₁), (x₁, x₂), (x₂, x₀) about the centers of the boxes, mirrored so
// that they cut off least of each other.
std::array<Polygon, 3> silhouettes_of(std::vector<Outline> profiles, int order = 0);

// Largest distance by which a polygon's outline extends beyond the silhouette of the body from all three
// polygons, relative to the polygon's diameter, measured along lines to the center of its box in steps of 50
// %. Contrary to the paper, the intersection does not always preserve the profiles as silhouettes: a tip of
// one needs room in both others.
double silhouette_deviation(const std::array<Polygon, 3>&);

}  // namespace terrazzo::shape_estimate
