// Pictures of solids: paths of light through the Studio, from the camera.
#pragma once

#include <cstdint>

#include "nodes/common/camera.h"
#include "nodes/data/image.h"
#include "nodes/render_solid/solid.h"
#include "nodes/render_solid/studio.h"
#include "runtime/work.h"

namespace terrazzo {

struct RenderSettings {
  int width = 720, height = 720;  // pixels
  int samples = 32;               // paths a pixel
  int bounces = 2;                // diffuse reflections between surfaces
  float gloss = 0.35f;            // share of a polished surface's mirror reflection, 0…1
  std::uint64_t seed = 1;
};

// The radiance of each pixel, scene-linear: what an unshadowed white surface facing up sends back is 1. The
// result does not depend on the number of threads.
//
// Light is counted as what an unoccluded surface would get, in closed form, plus what occluders change, by
// sampling. Surfaces that see the whole Studio are therefore free of noise, and the estimate stays unbiased
// (a control variate).
Image render(const Solid&, const Studio&, const Camera&, const RenderSettings&, const Work& = {});

}  // namespace terrazzo
