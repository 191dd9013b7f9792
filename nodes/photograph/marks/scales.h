// Rulers, tapes and scale cards, by their marks.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::segment {

// Rectangles around rulers, measuring tapes and scale cards, in a picture of 8-bit colors, as four corners in
// pixels. Each has ten marks, or nine edges of blocks, at equal distances (combs.h), and the two colors of
// these marks fill most of it; it is a strip or a card, longer than wide, and differs from what is on both
// sides. It may be turned, cross the picture, and be partly covered. `known`: captions, where nothing is
// searched.
std::vector<std::vector<cv::Point>> find_scales(const cv::Mat& levels, const std::vector<cv::Rect>& known,
                                                const Work&);

}  // namespace terrazzo::segment
