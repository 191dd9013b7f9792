#include "nodes/common/gl/egl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include <cstring>
#include <vector>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

Error no_gl(GlDevice device, const std::string& what) {
  return Error(
      "no-gl", what,
      device == GlDevice::Cpu
          ? "install Mesa's software renderer (libegl1, libgl1-mesa-dri), or use a method without OpenGL"
          : "set device: cpu, or install the GPU's EGL driver");
}

bool lists(const char* extensions, const char* name) {
  return extensions && std::strstr(extensions, name) != nullptr;
}

// Enumerates devices, which needs no window system and distinguishes software from hardware.
std::vector<EGLDeviceEXT> devices_of(GlDevice kind) {
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const auto text =
      reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(eglGetProcAddress("eglQueryDeviceStringEXT"));
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  EGLint count = 0;
  if (!lists(client, "EGL_EXT_platform_device") || !query || !text || !query(0, nullptr, &count) ||
      count == 0)
    throw no_gl(kind, "EGL found no devices");
  std::vector<EGLDeviceEXT> all(count), wanted;
  query(count, all.data(), &count);
  all.resize(count);
  for (const EGLDeviceEXT device : all)
    if (lists(text(device, EGL_EXTENSIONS), "EGL_MESA_device_software") == (kind == GlDevice::Cpu))
      wanted.push_back(device);
  if (wanted.empty())
    throw no_gl(kind, kind == GlDevice::Cpu ? "EGL found no software renderer" : "EGL found no GPU");
  return wanted;
}

}  // namespace

struct EglContext::Handles {
  EGLDisplay display = EGL_NO_DISPLAY, outer_display = eglGetCurrentDisplay();
  EGLContext context = EGL_NO_CONTEXT, outer = eglGetCurrentContext();
  void start(EGLDeviceEXT device, GlDevice kind);
  ~Handles() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    // All contexts of the process share EGL's display, so do not terminate it.
    if (outer == EGL_NO_CONTEXT)
      eglReleaseThread();
    else
      eglMakeCurrent(outer_display, EGL_NO_SURFACE, EGL_NO_SURFACE, outer);
  }
};

// Throws Error "no-gl" if the device does not support OpenGL 4.5.
void EglContext::Handles::start(EGLDeviceEXT device, GlDevice kind) {
  const auto display_of =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (display_of) display = display_of(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) {
    display = EGL_NO_DISPLAY;
    throw no_gl(kind, "the EGL device does not initialize");
  }
  if (!lists(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context") ||
      !eglBindAPI(EGL_OPENGL_API))
    throw no_gl(kind, "the EGL device does not support OpenGL without a surface");
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            4,
                            EGL_CONTEXT_MINOR_VERSION,
                            5,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &configs) || configs == 0) config = EGL_NO_CONFIG_KHR;
  context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
  if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
    throw no_gl(kind, "the EGL device does not support OpenGL 4.5 core");
}

EglContext::EglContext(GlDevice kind) {
  // Use the first device that works: a display adapter may precede the GPU.
  const auto devices = devices_of(kind);
  for (std::size_t i = 0; !handles_; ++i) try {
      auto handles = std::make_unique<Handles>();
      handles->start(devices[i], kind);
      handles_ = std::move(handles);
    } catch (const Error&) {
      if (i + 1 == devices.size()) throw;
    }
  if (const auto* name = function<PFNGLGETSTRINGPROC>("glGetString")(GL_RENDERER))
    renderer_ = reinterpret_cast<const char*>(name);
}

EglContext::~EglContext() = default;

EglContext::Proc EglContext::find(const char* name) const {
  const Proc found = eglGetProcAddress(name);
  if (!found)
    throw Error("no-gl", std::string("the OpenGL driver does not support ") + name, "install a newer driver");
  return found;
}

}  // namespace terrazzo
