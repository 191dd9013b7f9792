// Statistics of a crop that have names: lightness, color, edges, sharpness, direction, local patterns.
#pragma once

#include <Eigen/Dense>

#include "nodes/compare/texture_observer/crops.h"
#include "nodes/compare/texture_observer/feature_group.h"

namespace terrazzo::texture_observer {

// In the order of the columns.
const std::vector<FeatureGroup>& pattern_groups();

// One row per crop of the set. Every value is finite and depends on the pixels of its crop only.
Eigen::MatrixXd pattern_features(const CropSet&, const Work& = {});

}  // namespace terrazzo::texture_observer
