// Tone curves for pictures of light: scene-linear to what a display shows, still linear.
#pragma once

#include "nodes/data/image.h"

namespace terrazzo {

// The Academy's rendering for displays (ACES 1.0 SDR video) through OpenColorIO, in place: strong light rolls
// off like film and loses saturation. Linear Rec. 709 in and out, within [0, 1]. `exposure` multiplies first.
// Throws Error "color-config" where OpenColorIO has no such transform.
void aces_tone(Image&, float exposure = 1.6f);

}  // namespace terrazzo
