// The pixels that share an edge with a pixel.
#pragma once

namespace terrazzo::segment {

// Calls visit with the index of each of the up to four neighbors, in the order left, right, above, below.
template <class Index, class Visit>
void neighbors(Index i, int width, int height, Visit&& visit) {
  const int x = static_cast<int>(i % width), y = static_cast<int>(i / width);
  if (x > 0) visit(i - 1);
  if (x + 1 < width) visit(i + 1);
  if (y > 0) visit(i - width);
  if (y + 1 < height) visit(i + width);
}

}  // namespace terrazzo::segment
