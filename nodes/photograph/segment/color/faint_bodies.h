// Bodies whose color hardly differs from the binder's.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/color/mosaic.h"

namespace terrazzo::segment {

// For each of the labels from 1 to `count` (0: binder), one per pixel: whether the mean color of its patches
// is within six standard deviations of the noise of the median of the binder's. Such bodies are often patches
// of binder that particles enclose.
std::vector<bool> faint_bodies(const Mosaic&, const std::vector<std::int32_t>& labels, std::int32_t count);

}  // namespace terrazzo::segment
