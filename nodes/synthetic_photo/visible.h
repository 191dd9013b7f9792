// Which particles of a picture deserve a label.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/synthetic_photo/camera.h"
#include "nodes/synthetic_photo/canvas.h"

namespace terrazzo::synthetic_photo {

// Labels of the picture's pixels, from 1 without gaps: of each particle the largest connected piece, if it
// has at least `smallest` pixels and, on average along its border, differs from its surroundings by at least
// `contrast` (encoded, 0 to 1), so that a person would see it. `clear` is the picture without noise.
std::vector<std::int32_t> visible_particles(const Canvas&, const Picture& clear, int smallest,
                                            double contrast);

}  // namespace terrazzo::synthetic_photo
