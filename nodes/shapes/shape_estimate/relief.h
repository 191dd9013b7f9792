// How far the outlines of stones are from ellipses.
#pragma once

#include <vector>

#include "nodes/shapes/shape_estimate/outline.h"

namespace terrazzo::shape_estimate {

// Standard deviation of an outline's distance from its center, where the ellipse with the same area and
// moments is at 1: 0 for an ellipse.
double relief_of(const Outline&);

// The lower quartile of all outlines' relief: errors of outlines, such as parts that are hidden, only add to
// it. 0 without outlines.
double usual_relief(const std::vector<Outline>&);

// Usual relief below which all stones are taken for ellipsoids: balls drawn in pixels reach 0.02, and
// photographed stones have 0.04 or more.
inline constexpr double kRound = 0.03;

// The median share of a full turn that outlines take at corners (`crease` of make_outline): 1 for polygons, 0
// for smooth outlines.
double usual_corners(const std::vector<Outline>&);

// Usual corners above which stones are taken for crushed: photographed pebbles have 0.24 to 0.32, and crushed
// gravel 0.52, with a crease of 30°.
inline constexpr double kCrushed = 0.42;

}  // namespace terrazzo::shape_estimate
