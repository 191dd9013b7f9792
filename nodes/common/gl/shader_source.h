// GLSL sources, embedded from shaders/ at build time.
#pragma once

#include <string>

namespace terrazzo {

// Source by file name ("stencil_slice.vert"); null if there is none.
const char* shader_source(const std::string& name);

}  // namespace terrazzo
