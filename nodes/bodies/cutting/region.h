// Plane regions bounded by polygons: the outer loop first, then its holes.
#pragma once

#include <vector>

#include "nodes/common/geometry/mesh/mesh_section.h"

namespace terrazzo::section {

using Region = std::vector<Loop>;

struct Extent {
  Vec2 lo = Vec2::Zero(), hi = Vec2::Zero();
};

double region_area(const Region&);
double region_perimeter(const Region&);  // holes included
Vec2 region_centroid(const Region&);
Extent region_extent(const Region&);
Region translated(Region, const Vec2& by);

// The part within [0, width] × [0, height], empty if nothing is inside. A region that the window divides
// stays one region: edges of zero area along the border join its parts (Sutherland and Hodgman 1974).
Region clipped(const Region&, double width, double height);

// Area of the union of all regions within [0, width] × [0, height], exact to 1e-9 of the window. Applies
// Green's theorem to the parts of the outlines that no other region covers and to the covered parts of the
// window's border.
double union_area(const std::vector<Region>&, double width, double height);

}  // namespace terrazzo::section
