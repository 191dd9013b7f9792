// The colors of the material without the light that fell on it.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/photograph/marks/ignored.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// Removes three things from the photograph, which keeps its mean lightness.
//
// Uneven light is a smooth factor: the binder's lightness averaged over an eighth of the picture. Particles
// count a tenth, since their colors differ.
//
// The shading of a rounded particle is a + b·u + c·v + e·h, fitted to its luminance: Lambert's law of a dome,
// with position u, v and height h of the dome at this distance from the outline. It is brought to its
// median, as far as it explains the particle's variation.
//
// Gloss: pixels of a particle that are far lighter than the rest of it get its median color.
//
// Particles of less than 60 pixels keep their colors but for the uneven light. Cast shadows on the binder
// remain.
Image delight(const Image&, const Labels&, const IgnoredPixels&, const Work&);

}  // namespace terrazzo::segment
