// The visible pieces of stones as labels and profiles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/bodies/view/surface_view.h"
#include "nodes/common/geometry/mesh/loop.h"

namespace terrazzo::view {

// Adds the pieces of one picture, whose pixels are in the view's image, to labels, profiles and table. Pieces
// are 4-connected pixels of one stone; those of less than 12 pixels count as soil. Areas are counted in
// pixels. A piece that touches the border has weight 0; any other one has the weight of a volume's section:
// the number of pixels over that of the places where it fits with a free pixel on each side. `stone`: of each
// pixel, −1 in soil.
void add_pieces(SurfaceView&, int section, const std::vector<std::int32_t>& stone, const Bed&,
                const Particles&, const SurfaceOptions&);

// The outer outline of 4-connected pixels of one id, in pixels from the lower left corner, y up,
// counterclockwise: the middles of its pixels' outer edges, smoothed over three of them. `x`, `row`: the
// first of its pixels, row by row from the top.
Loop outline_of_pixels(const std::vector<std::int32_t>& ids, int width, int height, int x, int row);

}  // namespace terrazzo::view
