// The gray levels of phases, from a histogram.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace terrazzo::media {

// Ascending levels of `phases` phases, by the thresholds of Otsu (1979) for several classes. phases = 0: the
// peaks of the histogram that valleys of at most half their height separate, at most 5, the highest. Of two
// histograms, the one with more peaks counts: that of all pixels, and that of a smoothed picture's pixels
// inside phases, those with small gradients (Weszka and Rosenfeld 1979). Empty if there is one level, or
// if the levels differ by less than rounding to 8 bits.
std::vector<double> gray_levels(const cv::Mat1f& gray, const std::vector<std::uint8_t>& observed, int phases);

}  // namespace terrazzo::media
