#include "nodes/solids/synthesis/blockwise/statistics.h"

namespace terrazzo::solids {

ValueMap::ValueMap(const std::vector<float>& values, const Quantiles& target) {
  Remap map(target);
  Remap::Counts counts(Remap::kBins, 0);
  map.count(values.data(), values.size(), counts);
  map.finish(counts);
  map_ = std::make_shared<const Remap>(map.low(), map.scale(), map.bins());
}

}  // namespace terrazzo::solids
