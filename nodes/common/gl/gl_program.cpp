#include "nodes/common/gl/gl_program.h"

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/gl/shader_source.h"

namespace terrazzo {
namespace {

[[noreturn]] void refuse(const EglContext& context, const char* log, const char* hint) {
  throw Error("no-gl", "the driver " + context.renderer() + " rejects the shaders: " + log, hint)
      .parameter("device");
}

void attach(const EglContext& context, GLuint program, GLenum kind, const char* name, const char* hint) {
  const char* text = shader_source(name);
  const GLuint shader = context.function<PFNGLCREATESHADERPROC>("glCreateShader")(kind);
  context.function<PFNGLSHADERSOURCEPROC>("glShaderSource")(shader, 1, &text, nullptr);
  context.function<PFNGLCOMPILESHADERPROC>("glCompileShader")(shader);
  GLint good = 0;
  context.function<PFNGLGETSHADERIVPROC>("glGetShaderiv")(shader, GL_COMPILE_STATUS, &good);
  if (!good) {
    char log[1024] = "";
    context.function<PFNGLGETSHADERINFOLOGPROC>("glGetShaderInfoLog")(shader, sizeof log, nullptr, log);
    refuse(context, log, hint);
  }
  context.function<PFNGLATTACHSHADERPROC>("glAttachShader")(program, shader);
}

unsigned link(const EglContext& context, GLuint program, const char* hint) {
  context.function<PFNGLLINKPROGRAMPROC>("glLinkProgram")(program);
  GLint good = 0;
  context.function<PFNGLGETPROGRAMIVPROC>("glGetProgramiv")(program, GL_LINK_STATUS, &good);
  if (!good) {
    char log[1024] = "";
    context.function<PFNGLGETPROGRAMINFOLOGPROC>("glGetProgramInfoLog")(program, sizeof log, nullptr, log);
    refuse(context, log, hint);
  }
  return program;
}

}  // namespace

unsigned make_gl_program(const EglContext& context, const char* vertex, const char* fragment,
                         const char* hint) {
  const GLuint program = context.function<PFNGLCREATEPROGRAMPROC>("glCreateProgram")();
  attach(context, program, GL_VERTEX_SHADER, vertex, hint);
  attach(context, program, GL_FRAGMENT_SHADER, fragment, hint);
  return link(context, program, hint);
}

unsigned make_gl_program(const EglContext& context, const char* compute, const char* hint) {
  const GLuint program = context.function<PFNGLCREATEPROGRAMPROC>("glCreateProgram")();
  attach(context, program, GL_COMPUTE_SHADER, compute, hint);
  return link(context, program, hint);
}

void check_gl(const EglContext& context, const char* what, const char* smaller_hint, const char* hint) {
  const GLenum code = context.function<PFNGLGETERRORPROC>("glGetError")();
  if (code == GL_NO_ERROR) return;
  if (code == GL_OUT_OF_MEMORY)
    throw Error("too-large-for-gl", fmt::format("{} exceeds the memory of {}", what, context.renderer()),
                smaller_hint)
        .parameter("device");
  throw Error("no-gl", fmt::format("the driver {} failed with OpenGL error {}", context.renderer(), code),
              hint)
      .parameter("device");
}

}  // namespace terrazzo
