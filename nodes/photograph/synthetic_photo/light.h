// Light on the height map: sun with cast shadows, sky with occlusion, highlights.
#pragma once

#include <vector>

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

struct Light {
  double azimuth = 0, elevation = 1;  // of the sun, radians; y points down in the picture
  double sun = 1, sky = 0.5;
  double sky_azimuth = 0, sky_slope = 0;  // where the sky is brightest, and by how much, from 0 to 1
  double relief = 1;                      // factor on heights where the sky is looked for
  double bounce = 0;                      // share of the hidden sky that other surfaces replace
  double gloss = 0;                       // added to every surface
  double softness = 2;                    // width of the shadows' edges
};
// `face`: of an upright face, on which most light falls from the upper side of the picture.
Light random_light(Random&, bool polished, bool face);

// Radiance of every canvas pixel, scene-linear, about 0 to 1.
std::vector<Vec3f> shade(const Canvas&, const Light&, const Work&);

}  // namespace terrazzo::synthetic_photo
