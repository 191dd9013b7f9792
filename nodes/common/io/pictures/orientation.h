// EXIF's orientation of pictures.
#pragma once

#include <utility>
#include <vector>

#include "nodes/data/indices.h"

namespace terrazzo {

// Whether EXIF's orientation, from 1 (upright) to 8, says that a picture is stored turned or mirrored.
inline bool is_turned(int orientation) { return orientation >= 2 && orientation <= 8; }

// Turns and mirrors a picture of `count` values per pixel so that it is upright.
template <class T>
void make_upright(std::vector<T>& values, int& width, int& height, std::size_t count, int orientation) {
  if (!is_turned(orientation)) return;
  const bool swapped = orientation >= 5;
  const int w = swapped ? height : width, h = swapped ? width : height;
  std::vector<T> upright;
  upright.reserve(values.size());
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      int u = swapped ? y : x, v = swapped ? x : y;
      if (orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8) u = width - 1 - u;
      if (orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7) v = height - 1 - v;
      const std::size_t from = (pixel_at(u, v, width)) * count;
      for (std::size_t k = 0; k < count; ++k) upright.push_back(values[from + k]);
    }
  values = std::move(upright);
  width = w;
  height = h;
}

}  // namespace terrazzo
