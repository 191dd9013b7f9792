// The silhouette of a particle of which others hide a part.
#pragma once

#include "nodes/common/geometry/mesh/mesh_section.h"

namespace terrazzo {

// Area of the whole silhouette of a stone, in the units of its visible outline, counterclockwise. Where
// others hide it, the outline is bitten: the ellipse through the points that lie on its convex hull completes
// it. If no ellipse follows, the hull does. At least the area of the hull; an outline that is elliptic and
// not bitten has its own area.
double whole_silhouette(const Loop& visible);

}  // namespace terrazzo
