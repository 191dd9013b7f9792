// Rasterizes regions: exact area coverage, and the pixels whose centers lie inside.
#pragma once

#include <functional>

#include "nodes/bodies/cutting/region.h"

namespace terrazzo::section {

struct PixelGrid {
  int width = 0, height = 0;  // pixels
  double mm_x = 1, mm_y = 1;  // per pixel
  bool wrap = false;          // opposite edges join; otherwise regions must lie inside the grid

  int row(int y_up) const { return height - 1 - y_up; }  // image rows count from the top
};

// Calls visit(x, row, share) for every pixel that the region covers; share is the exact coverage, 0 … 1.
void cover_pixels(const Region&, const PixelGrid&, const std::function<void(int, int, double)>& visit);

// Calls visit(x, row) for every pixel whose center lies in the region.
void fill_pixels(const Region&, const PixelGrid&, const std::function<void(int, int)>& visit);

}  // namespace terrazzo::section
