// Few colors in place of many, for formats whose materials have one color each.
#pragma once

#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::exporting {

struct ColorClasses {
  std::vector<Vec3f> color;  // scene-linear; the mean of each class's members
  std::vector<int> of;       // class of each given color
};

// At most `most` classes (1 or more). Up to `most` distinct colors are kept exactly. More are grouped by the
// finest grid of equal steps of their sRGB-encoded channels that leaves at most `most` groups. Classes are
// numbered in the order of their first member.
ColorClasses color_classes(const std::vector<Vec3f>& colors, int most);

}  // namespace terrazzo::exporting
