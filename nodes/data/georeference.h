// Where a picture lies on a map.
#pragma once

#include <array>

#include "nodes/data/linear.h"

namespace terrazzo {

struct Georeference {
  // Of a point in pixels from the upper left corner of the first pixel, y down: map x = m[0]·column +
  // m[1]·row + m[2], and map y = m[3]·column + m[4]·row + m[5]. Pixels are squares, which may be turned.
  std::array<double, 6> m = {1, 0, 0, 0, -1, 0};
  int epsg = 0;  // number of the coordinate system; 0: unknown

  Vec2 on_map(const Vec2& pixel) const {
    return {m[0] * pixel.x() + m[1] * pixel.y() + m[2], m[3] * pixel.x() + m[4] * pixel.y() + m[5]};
  }
  Vec2 in_picture(const Vec2& map) const {
    const Vec2 d = map - Vec2(m[2], m[5]);
    return Vec2(m[4] * d.x() - m[1] * d.y(), m[0] * d.y() - m[3] * d.x()) / (m[0] * m[4] - m[1] * m[3]);
  }
};

}  // namespace terrazzo
