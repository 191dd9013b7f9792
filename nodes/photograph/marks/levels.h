// A section as its file stores it.
#pragma once

#include <opencv2/core.hpp>

#include "nodes/data/image.h"

namespace terrazzo::segment {

// Three channels of 8 bits, encoded sRGB: what most files hold, so that flat areas have one exact color.
cv::Mat levels_of(const Image&, int section);

// How far each pixel is from this color, in levels of one byte: the difference of its luma, or a quarter of
// the largest difference of a channel, since JPEG blurs colors more than light.
cv::Mat distance_from(const cv::Mat& levels, const cv::Vec3b& color);

// The most frequent color, the darkest in its last channel first.
cv::Vec3b commonest(const cv::Mat& levels);

}  // namespace terrazzo::segment
