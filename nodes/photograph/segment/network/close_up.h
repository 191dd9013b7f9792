// A candidate enlarged or reduced to one size, as the second network sees it.
#pragma once

#include <opencv2/core.hpp>

#include "nodes/photograph/segment/network/candidates.h"

namespace terrazzo::segment {

constexpr int kCloseUp = 48;        // rows and columns
constexpr int kCloseUpPlanes = 10;  // see CloseUp

// A square around a candidate, twice as wide as the candidate and at least 24 pixels; what lies beyond the
// section repeats its edge.
struct CloseUp {
  cv::Rect square;  // of the section; may reach beyond it
  // Red, green and blue less their means, divided by their common standard deviation; the candidate's mask;
  // inside, border and distance at the candidate's scale; inside and border at the section's own; a constant,
  // log₂ of the square's side / 48 pixels.
  std::array<cv::Mat, kCloseUpPlanes> planes;
};

// `picture`: the section, encoded sRGB from 0 to 1 in three channels. The mask must not be empty.
CloseUp close_up(const Cutout&, const cv::Mat& picture, const ScaleView& view, const ScaleView& own);

// The part of a map of the section that a close-up shows, in its size. Beyond the section, the map's edge is
// repeated.
cv::Mat seen_close(const cv::Mat& map, const cv::Rect& square);

}  // namespace terrazzo::segment
