// The parameter `device` of nodes that compute on the CPU or with OpenGL.
#pragma once

#include <memory>
#include <string>

#include "graph/diagnostic.h"
#include "nodes/common/gl/egl_context.h"
#include "runtime/context.h"

namespace terrazzo {

enum class Device { Cpu, Auto, Gl };

// What the parameter asks for: for gl an `Engine` on a GPU or else on Mesa's software renderer, for auto one
// on a GPU if there is one. Otherwise null: compute on the CPU. `make` takes a GlDevice and returns a
// unique_ptr<Engine>, or throws Error "no-gl". A warning tells what was `done` ("made", "rendered") where.
template <class Make>
auto open_gl(Context& c, const std::string& done, Make&& make) -> decltype(make(GlDevice::Gpu)) {
  const auto device = c.choice<Device>("device");
  if (device == Device::Cpu) return nullptr;
  decltype(make(GlDevice::Gpu)) engine;
  try {
    engine = make(GlDevice::Gpu);
  } catch (const Error& e) {
    if (device == Device::Auto) {
      c.warn(done + " on the CPU: " + e.diagnostic().message);
      return nullptr;
    }
    if (e.diagnostic().code != "no-gl") throw;
    engine = make(GlDevice::Cpu);
  }
  c.warn(done + " by OpenGL on " + engine->renderer());
  return engine;
}

}  // namespace terrazzo
