// Writes any value to a file, with a node type that accepts its type.
#pragma once

#include <filesystem>

#include "runtime/clients/cli/options.h"

namespace terrazzo::cli {

// Appends a node to `graph` that writes the value on the wire to `file`, and returns its index. To write
// particles as glTF, it uses the shapes from the nearest node upstream that outputs shapes. Throws Error
// "usage" if no node type writes values of this type.
int append_writer(const Registry&, Graph& graph, const Wire&, const std::filesystem::path& file);

}  // namespace terrazzo::cli
