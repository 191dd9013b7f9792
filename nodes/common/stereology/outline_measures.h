// Measures of one outline, as programs for image analysis define them.
#pragma once

#include "nodes/common/geometry/mesh/loop.h"

namespace terrazzo {

// In the unit of the outline.
struct OutlineMeasures {
  double perimeter = 0;
  // Of the ellipse with the same second moments (regionprops of scikit-image and MATLAB): 4 × the standard
  // deviations of the area.
  double major_axis = 0, minor_axis = 0;
  double orientation = 0;  // of the major axis, degrees counterclockwise from x, y up; 0 to 180, as in ImageJ
  double feret_max = 0, feret_min = 0;  // largest and smallest distance of two parallel tangents
  double circularity = 0;               // 4π area / perimeter²
  double solidity = 0;                  // area / area of the convex hull
};

// Of a counterclockwise outline, y up. All zeros if it has no area.
OutlineMeasures outline_measures(const Loop&);

}  // namespace terrazzo
