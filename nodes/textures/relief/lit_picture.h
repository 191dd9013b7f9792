// A picture of texture maps under a lamp, as an engine would show them.
#pragma once

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::textures {

// Two periods wide and high, seen from above, at most 1,024 pixels wide: a lamp from the upper left, and an
// even sky that `occlusion` dims. Lambert's law and GGX with a reflectance of 0.04, as in glTF. The maps have
// equal sizes. Displayable: a white surface that faces the lamp is about 1.
Image lit_picture(const Image& base_color, const Image& normal, const Image& roughness,
                  const Image& occlusion, const Work& = {});

}  // namespace terrazzo::textures
