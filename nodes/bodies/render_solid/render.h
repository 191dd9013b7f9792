// Path tracing of solids lit by the Studio.
#pragma once

#include <cstdint>
#include <functional>

#include "nodes/bodies/carving/solid.h"
#include "nodes/bodies/render_solid/studio.h"
#include "nodes/common/geometry/camera.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::render_solid {

using carving::Solid;

struct RenderOptions {
  int width = 720, height = 720;  // pixels
  // Light paths per pixel: four for each ray from the camera if divisible by four, or two if even.
  int samples = 32;
  int bounces = 2;      // diffuse reflections between surfaces
  float gloss = 0.35f;  // fraction of a polished surface's mirror reflection, 0…1
  std::uint64_t seed = 1;
};

// Returns the scene-linear radiance of each pixel, in units of the light reflected by an unshadowed white
// surface facing up. The result does not depend on the number of threads. The light on an unoccluded surface
// is computed in closed form, and the changes made by occluders are sampled and added (a control variate).
// Surfaces that see the whole Studio are therefore free of noise, and the estimate stays unbiased. `refined`
// receives the picture after 1, 2, 4, … rays per pixel; the result is the same to the bit.
Image render(const Solid&, const Studio&, const Camera&, const RenderOptions&, const Work& = {},
             const std::function<void(Image)>& refined = {});

}  // namespace terrazzo::render_solid
