// Any value to a file, by a node type that writes such values.
#pragma once

#include <filesystem>

#include "runtime/cli/options.h"

namespace terrazzo::cli {

// Appends to `graph` a node that writes the value on the wire to `file`, and returns its index. A
// packing's shapes come from the nearest node upstream that gives some. Throws Error "usage" where
// no node type writes such a value.
int append_writer(const Registry&, Graph& graph, const Wire&, const std::filesystem::path& file);

}  // namespace terrazzo::cli
