// The frame of a figure, and the bars of a picture that was padded to another shape.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace terrazzo::segment {

// The rectangles of a frame around a picture of 8-bit colors (levels.h), at most one at each edge. A frame
// has one flat color at two edges or more, at least three pixels wide, ends in a straight line, and has a
// color that is rare inside. `strips`: captions that run along an edge; the frame may begin behind them.
std::vector<cv::Rect> find_frame(const cv::Mat& levels, const std::vector<cv::Rect>& strips);

}  // namespace terrazzo::segment
