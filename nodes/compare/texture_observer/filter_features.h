// Random-feature convolution: whitened patches of the pictures themselves as filters.
#pragma once

#include <Eigen/Dense>

#include "nodes/compare/texture_observer/crops.h"
#include "nodes/compare/texture_observer/feature_group.h"

namespace terrazzo::texture_observer {

// Linear filters of 5 × 5 Oklab pixels, one matrix per resolution: response = weightsᵀ · pixels + offset.
// Responses to the patches that the filters were learned from have mean 0 and about unit variance.
struct FilterBank {
  std::array<Eigen::MatrixXf, kLevels> weights;  // 75 × number of filters
  std::array<Eigen::VectorXf, kLevels> offset;
};

struct CropRows {
  const CropSet* set = nullptr;
  std::vector<int> rows;  // indices into set->crops
};

// Draws whitened patches at random, alternately from the crops of both classes (Coates and Ng 2011).
// Exchanging the classes exchanges the filters in pairs. No class may be empty.
FilterBank learn_filters(const std::array<CropRows, 2>& classes, std::uint64_t seed);

// One group per resolution: filters that cover 5, 10 and 20 pixels.
const std::vector<FeatureGroup>& filter_groups();

// One row per crop of the set: for each filter, the means of its positive and of its negative response, its
// root mean square, and the mean root of its absolute value. Every value depends on the pixels of its crop
// only.
Eigen::MatrixXd filter_features(const CropSet&, const FilterBank&, const Work& = {});

}  // namespace terrazzo::texture_observer
