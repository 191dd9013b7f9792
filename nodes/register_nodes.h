// All node types and value types of this build. The list of nodes is made by CMake from the folders.
#pragma once

#include "graph/registry.h"
#include "runtime/value.h"

namespace terrazzo {

void register_nodes(Registry&);
void register_value_types(ValueTypes&);

}  // namespace terrazzo
