// Text that was written into a picture, with what lies under it.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace terrazzo::segment {

// The boxes of text and scale bars in white, black or a pure color, in a picture of 8-bit colors, but for
// text that touches one of `known`. A box has a margin of a third of the text's height, and includes the
// panel under the text: a flat rectangle, or one that the picture shines through, which is lighter or darker
// all along its upper and lower edge. Little of the same ink is around text, so specks of a saturated picture
// are none. A bar without text needs a flat rectangle all around it, or is the only one that is a rectangle
// of one exact color.
std::vector<cv::Rect> find_text_panels(const cv::Mat& levels, const std::vector<cv::Rect>& known);

}  // namespace terrazzo::segment
