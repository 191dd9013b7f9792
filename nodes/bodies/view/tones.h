// The tones of a picture.
#pragma once

#include <span>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::view {

// Changes how light colors are, by a curve that never decreases, so that as much of the picture is as dark as
// in a photograph with these Detail::tones: a camera's exposure and contrast. Hues stay.
void match_tones(std::span<Vec3f> colors, const std::vector<float>& tones);

}  // namespace terrazzo::view
