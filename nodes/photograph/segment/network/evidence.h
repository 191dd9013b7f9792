// What tells particles from other regions of a section.
#pragma once

#include <array>

#include "nodes/photograph/segment/network/candidates.h"

namespace terrazzo::segment {

// In this order: log of the area in pixels; log of the scale; log ratio of inside, within and around; log
// ratio of border, along the outline and within, at this scale and at the best one; lower fifth of border
// along the outline; upper tenth of border within; mean difference of distance from the region's own;
// compactness; solidity; ratio of the axes; largest distance to the outline relative to the root of the area;
// whether the section's edge cuts it; mean of not material. Ratios and shapes rather than the maps
// themselves, because the network is less certain of photographs than of the pictures it learned from.
constexpr int kEvidence = 14;
using Evidence = std::array<float, kEvidence>;

// `near_border`: the largest near_border() of all scales. The region must not be empty.
Evidence evidence_of(const Cutout&, const ScaleView&, const cv::Mat& near_border);

}  // namespace terrazzo::segment
