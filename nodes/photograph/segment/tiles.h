// Pictures too large to be segmented at once.
#pragma once

#include <vector>

#include "nodes/photograph/segment/find.h"

namespace terrazzo::segment {

// Whether a section has more than 4096² pixels. The size alone decides, so the result does not depend on
// memory.
bool needs_tiles(const Image&);

// A part of a section: the pixels that count, within those that are seen.
struct Tile {
  int section = 0;
  int left = 0, top = 0, right = 0, bottom = 0;                      // the core; right and bottom are outside
  int seen_left = 0, seen_top = 0, seen_right = 0, seen_bottom = 0;  // with the margin
};

// Cores of 2048² pixels that cover a picture, each with a margin of 256 pixels inside the picture.
std::vector<Tile> tiles_of(int width, int height, int sections);

// Segments tile after tile. The method of Method::Auto, and clusters and binder, are settled once, on up to
// four tiles. A particle belongs to the first tile whose core contains its centroid; parts of a particle
// larger than a margin are joined where they overlap. Throws Error "one-color", and "too-large" for
// Method::Scribbles.
Finding find_in_tiles(const Image&, const SegmentOptions&, const Work&);

}  // namespace terrazzo::segment
