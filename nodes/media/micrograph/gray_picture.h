// A micrograph as gray levels, and what they say of its phases.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/indices.h"
#include "nodes/media/micrograph/find_phases.h"

namespace terrazzo::media {

struct GrayPicture {
  int width = 0, height = 0;
  cv::Mat1f gray;                // along the main axis of display-encoded colors
  cv::Mat1f light;               // slow changes of it
  std::vector<std::uint8_t> in;  // 1 for observed pixels
  bool observed(int x, int y) const { return in[pixel_at(x, y, width)] != 0; }
  float at(int x, int y) const { return gray(y, x) - light(y, x); }
};

// Of the first section, without light. Throws Error "empty-image", "bad-pixels".
GrayPicture gray_picture(const Image&, const std::vector<std::uint8_t>& unobserved);

struct PhaseLevels {
  std::vector<double> level, noise;  // mean and standard deviation of each phase
};
// Of the observed pixels; a phase without any keeps what it has.
void measure(const GrayPicture&, const std::vector<std::uint8_t>& label, PhaseLevels&);

// The smallest distance between successive levels, in sums of their noise; below 0 if they are not in order.
double separation(const PhaseLevels&);

// All but `uncertain`.
FoundPhases summary(const Image&, const GrayPicture&, const std::vector<std::uint8_t>& label,
                    const PhaseLevels&);

}  // namespace terrazzo::media
