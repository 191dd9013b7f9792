// Shader programs of an EglContext.
#pragma once

#include "nodes/common/egl_context.h"

namespace terrazzo {

// A linked program of two embedded shaders, by file name. Throws Error "no-gl" with the driver's words,
// `hint` and the parameter "device" where the driver refuses them.
unsigned make_gl_program(const EglContext&, const char* vertex, const char* fragment, const char* hint);
// Throws Error "too-large-for-gl" where the driver ran out of memory, of which `what` would not fit, "no-gl"
// after any other error of it; both with a hint and the parameter "device".
void check_gl(const EglContext&, const char* what, const char* smaller_hint);
// The same as make_gl_program of one compute shader.
unsigned make_gl_program(const EglContext&, const char* compute, const char* hint);

}  // namespace terrazzo
