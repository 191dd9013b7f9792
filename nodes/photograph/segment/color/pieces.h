// Shape measures of the pieces of a raster, in pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::segment {

struct Piece {
  double area = 0;
  double hull_area = 0;                            // convex hull of the pixel squares
  double outline = 0;                              // pixel edges next to value 0
  double contact = 0;                              // pixel edges next to other pieces
  double at_border = 0;                            // pixel edges on the image border
  int left = 0, top = 0, right = -1, bottom = -1;  // first and last column and row
  double solidity() const { return hull_area > 0 ? area / hull_area : 0; }
};

// Element k − 1 describes piece k.
std::vector<Piece> measure_pieces(const std::vector<std::int32_t>& raster, int width, int height);

}  // namespace terrazzo::segment
