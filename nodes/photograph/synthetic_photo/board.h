// Flat things that lie on the scene.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "nodes/common/geometry/rank.h"
#include "nodes/photograph/synthetic_photo/canvas.h"
#include "runtime/random.h"

namespace terrazzo::synthetic_photo {

// A turned rectangle on the canvas.
struct Board {
  double x, y, half_length, half_width, cosine, sine;

  static Board turned(double x, double y, double half_length, double half_width, double angle) {
    return {x, y, half_length, half_width, std::cos(angle), std::sin(angle)};
  }
  bool inside(double px, double py, double& along, double& across) const {
    along = cosine * (px - x) + sine * (py - y);
    across = cosine * (py - y) - sine * (px - x);
    return std::abs(along) < half_length && std::abs(across) < half_width;
  }
};

// The color of paint, plastic, metal, wood.
Vec3f paint_color(Random&);
// An angle: half of all things lie along the picture.
double angle_of_thing(Random&);

// Lays a thing that is as high as nearly all of what is below it, and `thickness` more. `shade` gives the
// color at (along, across), or none where the rectangle is empty.
template <class Shade>
void lay(Canvas& c, const Board& board, double thickness, Shade&& shade) {
  const double reach = std::hypot(board.half_length, board.half_width);
  double along = 0, across = 0;
  const int x0 = std::max<int>(0, board.x - reach), x1 = std::min<int>(c.width - 1, board.x + reach);
  const int y0 = std::max<int>(0, board.y - reach), y1 = std::min<int>(c.height - 1, board.y + reach);
  std::vector<float> heights;
  for (int y = y0; y <= y1; y += 3)
    for (int x = x0; x <= x1; x += 3)
      if (board.inside(x, y, along, across)) heights.push_back(c.z[c.at(x, y)]);
  if (heights.empty()) return;
  const float ground = at_rank(heights, heights.size() * 9 / 10) + static_cast<float>(thickness);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      if (!board.inside(x, y, along, across)) continue;
      const std::optional<Vec3f> color = shade(along, across);
      if (!color) continue;
      const std::size_t i = c.at(x, y);
      c.z[i] = std::max(c.z[i], ground);
      c.id[i] = 0;
      c.other[i] = 1;
      c.gloss[i] = 0.1f;
      c.color[i] = *color;
    }
}

}  // namespace terrazzo::synthetic_photo
