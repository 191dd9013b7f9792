// The node reference: one page per node type, generated from its declaration and its example.
#pragma once

#include <filesystem>

#include "runtime/clients/cli/options.h"

namespace terrazzo::cli {

// Writes NAME.md for every node type and an index (README.md) to `folder`. `examples` contains one folder per
// node type with its example.yaml. With `pictures`, runs each example and writes its picture to
// images/NAME.png. Pages link to these pictures even if they are not written now. Throws Error if an example
// has errors or its run fails.
void write_reference(const Program&, const std::filesystem::path& folder,
                     const std::filesystem::path& examples, bool pictures, const GraphOptions&);

}  // namespace terrazzo::cli
