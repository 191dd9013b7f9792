// Light on the height map: sun with cast shadows, sky with occlusion, highlights.
#pragma once

#include <vector>

#include "nodes/synthetic_photo/canvas.h"
#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

struct Light {
  double azimuth = 0, elevation = 1;  // of the sun, radians
  double sun = 1, sky = 0.5;
  double occlusion = 1;  // strength
  double gloss = 0;      // added to every surface
  double softness = 2;   // width of the shadows' edges
};
Light random_light(Random&, bool polished);

// Radiance of every canvas pixel, scene-linear, about 0 to 1.
std::vector<Vec3f> shade(const Canvas&, const Light&, const Work&);

}  // namespace terrazzo::synthetic_photo
