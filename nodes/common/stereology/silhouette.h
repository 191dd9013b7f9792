// The silhouette of a particle of which others hide a part.
#pragma once

#include "nodes/common/geometry/mesh/mesh_section.h"

namespace terrazzo {

// Area of the whole silhouette of a stone of which others hide a part, in the units of its visible outline,
// counterclockwise. Stones that hide it bite into the outline. The ellipse through the points that lie on the
// outline's convex hull completes it; if no ellipse follows from them, the hull does. At least the hull's
// area.
double whole_silhouette(const Loop& visible);

}  // namespace terrazzo
