// Stones of a surface: their silhouettes from above, and the axis that no photograph shows.
#pragma once

#include <vector>

#include "nodes/shapes/shape_estimate/outline.h"
#include "nodes/shapes/shape_estimate/section_sample.h"

namespace terrazzo::shape_estimate {

// Silhouettes of a body that lies with its z axis upright, give or take kTilt, from evenly spread directions,
// `views` of them starting at element `first`. Each has the weight 1. Bays that no ray from the middle
// reaches are filled.
std::vector<CutProfile> seen_from_above(const Mesh&, std::size_t views, std::size_t first = 0);

// The ratio of the short to the middle axis that is assumed for stones that lie flat, since the photograph
// shows only the two longer ones: the median ratio of these two. Both ratios are similar for river gravel,
// about 0.7 (Zingg 1935), and equal for balls. 1 without outlines.
double assumed_thickness(const std::vector<Outline>&);

// Turns the body's shortest axis to z.
void lie_down(Mesh&);

// Scales the body along z until its height is `ratio` times the shorter axis of its silhouette from above,
// about its middle.
void give_thickness(Mesh&, double ratio);

}  // namespace terrazzo::shape_estimate
