// Regions as pixels: exact area coverage, and the pixels whose centres lie inside.
#pragma once

#include <functional>

#include "nodes/section/region.h"

namespace terrazzo {

struct PixelGrid {
  int width = 0, height = 0;  // pixels
  double mm_x = 1, mm_y = 1;  // per pixel
  bool wrap = false;          // the opposite edges join; otherwise regions must lie within

  int row(int y_up) const { return height - 1 - y_up; }  // pictures count rows from the top
};

// visit(x, row, share) for every pixel that the region covers; share in 0 … 1, exact.
void cover_pixels(const Region&, const PixelGrid&, const std::function<void(int, int, double)>& visit);

// visit(x, row) for every pixel whose centre lies in the region.
void fill_pixels(const Region&, const PixelGrid&, const std::function<void(int, int)>& visit);

}  // namespace terrazzo
