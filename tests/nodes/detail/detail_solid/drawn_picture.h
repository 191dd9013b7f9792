// Pictures with known detail: disks in a binder.
#pragma once

#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"

namespace terrazzo::test {

struct DrawnPicture {
  Image image;
  Labels labels;
};

// Disks on a grid, every second one of the second color. `encoded(x, y, id)` gives the sRGB-encoded color.
template <class Color>
DrawnPicture draw_disks(int size, int step, double radius, Color&& encoded) {
  DrawnPicture out{Image(size, size, 1, 0.1), {}};
  Labels& l = out.labels;
  l.width = l.height = size;
  l.pixel_size = 0.1;
  l.ids.assign(static_cast<std::size_t>(size) * size, 0);
  const int n = size / step;
  l.classes.assign(static_cast<std::size_t>(n) * n, 0);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const int i = x / step, j = y / step;
      const double cx = (i + 0.5) * step, cy = (j + 0.5) * step;
      const bool in = i < n && j < n && std::hypot(x + 0.5 - cx, y + 0.5 - cy) < radius;
      const int id = in ? j * n + i + 1 : 0;
      l.ids[l.index(x, y)] = id;
      out.image.at(x, y) = srgb_to_linear(encoded(x, y, id));
    }
  return out;
}

}  // namespace terrazzo::test
