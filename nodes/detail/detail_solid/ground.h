// What else a photograph of a surface shows: the soil between stones, and how light and dark it is.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// The window of at most 512 pixels square with most soil. Soil continues where stones and their shadows were
// (fill.h), and at each edge as at the opposite one. Nothing of other views, of loose stones, of windows
// below 48 pixels and of less than a tenth soil. `mask`: not 0 where a pixel is no soil; may be null.
Detail::Ground find_ground(const Image&, const Labels&, const Labels* mask, const Profiles&,
                           std::uint64_t seed, const Work& = {});

// Detail::tones of a surface, where the mask is not 1; nothing of other views. Other pixels of the mask show
// the material too: often the shadows between stones, where nobody can tell one stone from another. The
// photograph must have passed check_photograph.
std::vector<float> find_tones(const Image&, const Labels* mask, const Profiles&);

}  // namespace terrazzo::detail_solid
