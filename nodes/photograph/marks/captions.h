// Captions: the data bar of a microscope, and text that was written into a picture.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace terrazzo::segment {

// Boxes of pixels that show a caption and no material, in a picture of 8-bit colors (levels.h). A picture has
// one if
// - a strip of at most 0.35 of the picture runs from side to side at an edge, its boundary lies in one row or
// column,
//   and it has one flat color, but for text and lines;
// - a frame surrounds the picture (frame.h); or
// - text is written into the picture in white, black or a pure color (text_lines.h). The flat panel under it
//   belongs to it, and so does one that the picture shines through.
std::vector<cv::Rect> find_captions(const cv::Mat& levels);

// The height of a strip with text at the lower edge of a picture of 8-bit colors; 0: there is none.
int strip_height(const cv::Mat& levels);

}  // namespace terrazzo::segment
