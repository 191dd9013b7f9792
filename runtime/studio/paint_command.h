// terrazzo paint IMAGE
#pragma once

#include "runtime/studio/paint_options.h"

namespace terrazzo::studio {

// Serves the page until it is stopped. Returns the exit code.
int paint(const PaintOptions&);

}  // namespace terrazzo::studio
