// Statistics of a whole level that every part of it needs, measured on a probe.
#pragma once

#include <memory>
#include <vector>

#include "nodes/common/texture/quantiles.h"

namespace terrazzo::solids {

// An increasing map of values that never changes.
class ValueMap {
 public:
  // Maps the distribution of `values` to `target`; applies to values outside that sample too.
  ValueMap(const std::vector<float>& values, const Quantiles& target);
  explicit ValueMap(Remap finished) : map_(std::make_shared<const Remap>(std::move(finished))) {}
  void apply(float* values, std::size_t n) const { map_->apply(values, n); }
  const Remap& map() const { return *map_; }

 private:
  std::shared_ptr<const Remap> map_;
};

// The maps for one channel in one round of the finish: each plane's bands, then the values.
struct FinishMaps {
  std::vector<std::vector<ValueMap>> bands;  // [family][band]
  std::vector<ValueMap> values;              // one entry
};

struct LevelStatistics {
  std::vector<std::vector<float>> penalty;      // [exemplar][texel]: penalty on patches used more often than
                                                // average, from the use in the whole level below
  std::vector<std::vector<ValueMap>> values;    // [blend][channel]; blend 0 follows carrying up
  std::vector<std::vector<float>> floor;        // [iteration][family]: mean squared distance
  std::vector<std::vector<FinishMaps>> finish;  // [channel][round]
};

}  // namespace terrazzo::solids
