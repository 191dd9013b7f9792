// Shape measures of the pieces of a raster, in pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"

namespace terrazzo {

struct Piece {
  double area = 0;
  double hull_area = 0;                            // of the pixels' squares
  double outline = 0;                              // pixel edges towards 0
  double contact = 0;                              // pixel edges towards other pieces
  double at_border = 0;                            // pixel edges on the border of the picture
  int left = 0, top = 0, right = -1, bottom = -1;  // first and last column and row
  double solidity() const { return hull_area > 0 ? area / hull_area : 0; }
};

// Of piece k at k − 1.
std::vector<Piece> measure_pieces(const std::vector<std::int32_t>& raster, int width, int height);

// Area of the convex hull of points; sorts them (Andrew's monotone chain).
double hull_area(std::vector<Vec2>& points);

}  // namespace terrazzo
