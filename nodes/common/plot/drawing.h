// Antialiased strokes, rectangles and text in an Image. Positions are in pixels, y down; pixel (0, 0) covers
// [0, 1)².
#pragma once

#include <string>
#include <vector>

#include "nodes/data/image.h"

namespace terrazzo {

// Coverage mask in a window of an image, accumulated before painting so that overlapping strokes of one mark
// do not darken twice.
class Coverage {
 public:
  Coverage(int width, int height) : width_(width), height_(height) {}
  // Polyline with round caps; a single point is a disk.
  void stroke(const std::vector<Vec2>& points, double pen_width);
  void disc(const Vec2& center, double radius) { stroke({center}, 2 * radius); }
  void rectangle(double x0, double y0, double x1, double y1);
  // Blends in sRGB, as displays show it, so that thin marks keep their visual weight. Clears the coverage.
  void paint(Image&, const Vec3f& linear_color, double opacity = 1);

 private:
  void grow(int x0, int y0, int x1, int y1);
  float& at(int x, int y) { return mask_[static_cast<std::size_t>(y - y0_) * (x1_ - x0_) + (x - x0_)]; }
  int width_, height_;
  int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;  // the window covered so far
  std::vector<float> mask_;
};

enum class Turn { None, Left };  // Left: text runs upwards

// Adds text to `mask`; (x, y) is the top left corner of the line box in reading direction. Returns the width.
double add_text(Coverage& mask, double x, double y, const std::string& text, double height,
                Turn turn = Turn::None, double weight = 1);
double text_extent(const std::string& text, double height);

}  // namespace terrazzo
