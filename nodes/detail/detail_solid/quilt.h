// A seamless texture from the places where a picture shows it.
#pragma once

#include <cstdint>

#include "nodes/detail/detail_solid/fill.h"

namespace terrazzo::detail_solid {

// A picture of about this size that continues beyond each edge at the opposite one, sewn together from known
// square pieces that overlap by a third and are cut where they differ least (Efros and Freeman 2001). Pieces
// are as large as they can be and still show half of the known places. Empty if the known places are too
// narrow for pieces of 12 pixels.
PartialPicture quilt_picture(const PartialPicture& from, int width, int height, std::uint64_t seed,
                             const Work& = {});

}  // namespace terrazzo::detail_solid
