#include "nodes/common/egl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include <cstring>
#include <vector>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

Error no_gl(GlDevice device, const std::string& what) {
  return Error("no-gl", what,
               device == GlDevice::Cpu
                   ? "install Mesa's software renderer (libegl1, libgl1-mesa-dri), or use a "
                     "method that needs no OpenGL"
                   : "set device: cpu, or install the GPU's EGL driver");
}

bool lists(const char* extensions, const char* name) {
  return extensions && std::strstr(extensions, name) != nullptr;
}

// The device by enumeration, which needs no window system and tells software from hardware.
EGLDeviceEXT device_of(GlDevice kind) {
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const auto text =
      reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(eglGetProcAddress("eglQueryDeviceStringEXT"));
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  EGLint count = 0;
  if (!lists(client, "EGL_EXT_platform_device") || !query || !text || !query(0, nullptr, &count) ||
      count == 0)
    throw no_gl(kind, "EGL finds no devices here");
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  query(count, devices.data(), &count);
  for (EGLint i = 0; i < count; ++i) {
    const bool software = lists(text(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software");
    if (software == (kind == GlDevice::Cpu)) return devices[i];
  }
  throw no_gl(kind, kind == GlDevice::Cpu ? "EGL has no software renderer here" : "EGL finds no GPU here");
}

}  // namespace

struct EglContext::Handles {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  ~Handles() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    // The display itself is EGL's, shared by all contexts of the process: ending it would end theirs.
    eglReleaseThread();
  }
};

EglContext::EglContext(GlDevice kind) : handles_(std::make_unique<Handles>()) {
  const auto display_of =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  const EGLDeviceEXT device = device_of(kind);
  if (display_of) handles_->display = display_of(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
  EGLint major = 0, minor = 0;
  if (handles_->display == EGL_NO_DISPLAY || !eglInitialize(handles_->display, &major, &minor)) {
    handles_->display = EGL_NO_DISPLAY;
    throw no_gl(kind, "EGL's device does not start");
  }
  if (!lists(eglQueryString(handles_->display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context") ||
      !eglBindAPI(EGL_OPENGL_API))
    throw no_gl(kind, "EGL's device has no OpenGL without a surface");
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
  if (!eglChooseConfig(handles_->display, wanted, &config, 1, &configs) || configs == 0)
    config = EGL_NO_CONFIG_KHR;
  handles_->context = eglCreateContext(handles_->display, config, EGL_NO_CONTEXT, version);
  if (handles_->context == EGL_NO_CONTEXT ||
      !eglMakeCurrent(handles_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, handles_->context))
    throw no_gl(kind, "OpenGL 4.5 core cannot be had from EGL's device");
  if (const auto* name = function<PFNGLGETSTRINGPROC>("glGetString")(GL_RENDERER))
    renderer_ = reinterpret_cast<const char*>(name);
}

EglContext::~EglContext() = default;

EglContext::Proc EglContext::find(const char* name) const {
  const Proc found = eglGetProcAddress(name);
  if (!found) throw Error("no-gl", std::string("OpenGL has no ") + name + " here", "install a newer driver");
  return found;
}

}  // namespace terrazzo
