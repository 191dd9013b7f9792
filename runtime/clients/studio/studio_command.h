// The command `terrazzo studio [GRAPH | PHOTOGRAPH]`.
#pragma once

#include "runtime/clients/studio/studio_options.h"

namespace terrazzo::studio {

// Serves the page until the user stops the program. Returns the exit code.
int studio(const StudioOptions&, const NodeSet&);

}  // namespace terrazzo::studio
