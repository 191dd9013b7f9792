// Printed text and scale bars in a mask.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace terrazzo::segment {

// The boxes of text and of scale bars with text, in `ink`, a mask of bytes where 255 is ink and 0 is not. A
// letter is a component of thin strokes, at most `highest` pixels high. Text is a row of at least four
// letters that stand on one line, have strokes of one width and differ in width themselves, three of them of
// one height; or of at least two letters beside a bar, which is a horizontal run of at least 25 pixels, three
// times as long as high, with or without ticks at its ends. Then two letters that go on with text are text
// too. Text reads from left to right; turn the mask to find other text.
std::vector<cv::Rect> find_text(const cv::Mat& ink, int highest);

// The boxes of all such bars, with text or without.
std::vector<cv::Rect> find_bars(const cv::Mat& ink);

}  // namespace terrazzo::segment
