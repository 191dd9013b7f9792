// The three silhouettes that constructive solid geometry makes a body of (Jagnow et al. 2008, 3.2).
#pragma once

#include <array>
#include <vector>

#include "nodes/shape_estimate/extrusions.h"
#include "nodes/shape_estimate/outline.h"

namespace terrazzo::shape_estimate {

// Three profiles by falling aspect ratio (or another of six `order`s), scaled to bounding boxes of a × b, b ×
// c and a × c, a and b being the first one's and c what keeps the third one's aspect ratio; as polygons of
// (x₀, x₁), (x₁, x₂), (x₂, x₀), about the boxes' centres. Mirrored so that they cut least of each other.
std::array<Polygon, 3> silhouettes_of(std::vector<Outline> profiles, int order = 0);

// How far a polygon's outline reaches beyond the silhouette of the body that all three make, at most, of its
// diameter: along lines to the centre of its box, in steps of 50 %. That the intersection keeps the profiles
// as silhouettes whatever they are, as the paper has it, is not so: a tip of one needs room in both others.
double silhouette_deviation(const std::array<Polygon, 3>&);

}  // namespace terrazzo::shape_estimate
