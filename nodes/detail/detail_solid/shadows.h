// Shadows that stones cast: dark places at an outline.
#pragma once

#include <opencv2/core.hpp>

namespace terrazzo::detail_solid {

// Standard deviation of a normal distribution over the median of its absolute deviations.
inline constexpr float kOfNormal = 1.4826F;

// 255 outside, and where dark places, connected by edges or corners, reach it; 0 elsewhere. Masks of one
// size, 8-bit, not 0 where true.
cv::Mat outside_with_shadows(const cv::Mat& outside, const cv::Mat& dark);

}  // namespace terrazzo::detail_solid
