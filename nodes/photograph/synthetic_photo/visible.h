// Which particles of a picture deserve a label.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/synthetic_photo/camera.h"
#include "nodes/photograph/synthetic_photo/canvas.h"

namespace terrazzo::synthetic_photo {

struct Visible {
  std::vector<std::int32_t> labels;   // from 1 without gaps; 0: no particle, or an unclear one
  std::vector<std::uint8_t> unclear;  // 1 on pieces of particles that have no label
};

// Of each particle the largest connected piece gets a label, if it has at least `smallest` pixels and, on
// average along its border, differs from its surroundings by at least `contrast` (encoded, 0 to 1), so that a
// person would see it. `clear` is the picture without noise.
Visible visible_particles(const Canvas&, const Picture& clear, int smallest, double contrast);

}  // namespace terrazzo::synthetic_photo
