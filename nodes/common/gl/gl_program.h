// Shader programs of an EglContext.
#pragma once

#include "nodes/common/gl/egl_context.h"

namespace terrazzo {

// Links a program from two embedded shaders, given by file name. If the driver rejects them, throws Error
// "no-gl" with the driver's log, `hint` and the parameter "device".
unsigned make_gl_program(const EglContext&, const char* vertex, const char* fragment, const char* hint);
// Throws Error "too-large-for-gl" with `smaller_hint` if the driver ran out of memory for `what`, "no-gl"
// with `hint` after any other OpenGL error; both with the parameter "device".
void check_gl(const EglContext&, const char* what, const char* smaller_hint, const char* hint);
// Links a program from one compute shader, like above.
unsigned make_gl_program(const EglContext&, const char* compute, const char* hint);

}  // namespace terrazzo
