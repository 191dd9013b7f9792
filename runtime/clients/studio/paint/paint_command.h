// The command `terrazzo paint IMAGE`.
#pragma once

#include "runtime/clients/studio/paint/paint_options.h"

namespace terrazzo::studio {

// Serves the page until the user stops the program. Returns the exit code.
int paint(const PaintOptions&);

}  // namespace terrazzo::studio
