// Parts of a photograph that show no material: rulers, frames, captions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/linear.h"

namespace terrazzo::segment {

// 1 for each ignored pixel of a stack; empty if nothing is ignored.
using IgnoredPixels = std::vector<std::uint8_t>;

// 1 for each pixel of a stack that shows neither a particle that was found nor surely binder; empty if there
// is none. It counts as not observed where areas are measured, but profiles beside it were seen whole.
using UndecidedPixels = std::vector<std::uint8_t>;

// A polygon in pixels, x to the right and y down from the upper left corner of the picture. A pixel belongs
// to it if its center does (even-odd rule).
using Area = std::vector<Vec2>;

// Reads "x0 y0 x1 y1", two corners of a rectangle, or "x0 y0 x1 y1 x2 y2 …", a polygon. Commas and blanks
// separate the numbers. Throws Error "bad-region".
Area read_area(const std::string& text);

// Marks the areas in all sections, and the non-zero pixels of `mask` if there is one. Throws Error
// "size-mismatch" if the mask is of another picture, "empty-image" if no pixel is left.
IgnoredPixels ignored_pixels(const Image&, const std::vector<Area>& areas, const Labels* mask);

// Mirrors the section at the edge of what is ignored, so that the ignored part adds no color of its own and
// has the noise of the rest.
void cover_ignored(Image&, int section, const IgnoredPixels&);

// Number of positions in which the w × h pixels of a profile, with a rim of one pixel, lie in the picture and
// touch no ignored pixel.
class Positions {
 public:
  Positions(const std::uint8_t* ignored, int width, int height);
  std::int64_t count(int w, int h) const;
  // Whether the place with this upper left pixel of the profile is one of them.
  bool contains(int left, int top, int w, int h) const;

 private:
  int width_, height_;
  std::vector<std::int32_t> sums_;  // of the ignored pixels above and to the left
};

}  // namespace terrazzo::segment
