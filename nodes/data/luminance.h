// Luminance of colors.
#pragma once

#include "nodes/data/linear.h"

namespace terrazzo {

// Of a scene-linear color (ITU-R BT.709).
inline float luminance_of(const Vec3f& c) { return 0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2]; }

}  // namespace terrazzo
