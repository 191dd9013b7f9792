// The scale that rulers and scale bars in a photograph offer.
#pragma once

#include <cstdint>
#include <optional>

#include "nodes/data/image.h"
#include "nodes/photograph/marks/ignored.h"

namespace terrazzo::segment {

// Marks at equal distances, or a bar, on something that is not material. Lengths in pixels.
struct ScaleMark {
  enum class Kind { Ticks, Bar } kind = Kind::Ticks;
  double length = 0;       // distance of neighboring ticks, or length of the bar
  double uncertainty = 0;  // of the length
};

// A box of pixels from the upper left corner of a section, first and last column and row.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
};

// Looks at the ignored pixels in the box. If they are long and narrow, ticks are the shortest period that
// repeats at least five times along any of nine lines parallel to their axis, by autocorrelation; it is
// measured over as many ticks as agree. Otherwise a bar is the longest horizontal run of one lightness, at
// least two rows high, that ends within the box. Perspective is not considered. None if there is neither.
// `first`: what to look for first; captions have bars, and their letters may repeat.
std::optional<ScaleMark> find_scale(const Image&, int section, const PixelBox&, const IgnoredPixels&,
                                    ScaleMark::Kind first = ScaleMark::Kind::Ticks);

}  // namespace terrazzo::segment
