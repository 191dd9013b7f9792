// OpenGL 4.5 without a window through surfaceless EGL, on a GPU or on Mesa's software renderer.
#pragma once

#include <memory>
#include <string>

namespace terrazzo {

enum class GlDevice {
  Cpu,  // Mesa's llvmpipe: slow, but identical pixels on every machine with the same Mesa version
  Gpu   // the first EGL hardware device that works
};

// A core context, current on its creating thread, where it must be destroyed. Contexts of a thread nest: the
// inner one gives way to the outer one again. So a thread that waits for others may run a task with a context
// of its own meanwhile.
class EglContext {
 public:
  // Throws Error "no-gl" if there is no such device, no EGL, or no OpenGL 4.5.
  explicit EglContext(GlDevice);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  const std::string& renderer() const { return renderer_; }
  // An OpenGL function by name, cast to its PFNGL…PROC type (GL/glcorearb.h). Throws Error "no-gl" if it is
  // missing.
  template <class Function>
  Function function(const char* name) const {
    return reinterpret_cast<Function>(find(name));
  }

 private:
  using Proc = void (*)();
  Proc find(const char* name) const;
  struct Handles;
  std::unique_ptr<Handles> handles_;
  std::string renderer_;
};

}  // namespace terrazzo
