// GLSL sources, embedded at build from shaders/.
#pragma once

#include <string>

namespace terrazzo {

// By file name ("stencil_slice.vert"); null where there is none.
const char* shader_source(const std::string& name);

}  // namespace terrazzo
