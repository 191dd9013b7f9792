// How a written file says it was made.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo {

// The JSON that Export put into a picture, a .glb or a .vdb; "" where there is none or the file cannot be
// read.
std::string read_provenance(const std::filesystem::path&);

}  // namespace terrazzo
