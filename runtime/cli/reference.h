// The reference: a page for each node type, from its one declaration and its example.
#pragma once

#include <filesystem>

#include "runtime/cli/options.h"

namespace terrazzo::cli {

// Writes NAME.md for every type and an index (README.md) to `folder`. `examples`: holds a folder for each
// node type with its example.yaml. With `pictures` each example is run and what there is to see of it written
// to images/NAME.png; pages name these pictures whether or not they are written now. Throws what running an
// example throws.
void write_reference(const Program&, const std::filesystem::path& folder,
                     const std::filesystem::path& examples, bool pictures, const GraphOptions&);

}  // namespace terrazzo::cli
