// All node types and value types of this build. CMake collects them from the folders: each node.cpp defines
// FOLDER_node(), each value_types.cpp defines FOLDER_value_types(ValueTypes&).
#pragma once

#include "graph/registry.h"
#include "runtime/value.h"

namespace terrazzo {

void register_nodes(Registry&);
void register_value_types(ValueTypes&);

}  // namespace terrazzo
