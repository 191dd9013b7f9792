// What every part of a level must know of the whole one, and what it is measured on.
#pragma once

#include <memory>
#include <vector>

#include "nodes/common/quantiles.h"

namespace terrazzo::solid_optimize {

// A rising map of values, fixed once.
class ValueMap {
 public:
  // What turns the distribution of `values` into `target`. Values added later are mapped likewise.
  ValueMap(const std::vector<float>& values, const Quantiles& target);
  explicit ValueMap(Remap finished) : map_(std::make_shared<const Remap>(std::move(finished))) {}
  void apply(float* values, std::size_t n) const { map_->apply(values, n); }
  const Remap& map() const { return *map_; }

 private:
  std::shared_ptr<const Remap> map_;
};

// Of one channel after a round of the finish: each plane's bands, then the values.
struct FinishMaps {
  std::vector<std::vector<ValueMap>> bands;  // [family][band]
  std::vector<ValueMap> values;              // one
};

struct LevelStatistics {
  std::vector<std::vector<float>> penalty;      // [exemplar][texel]: how much further a patch in use more
                                                // often than others counts, as the whole level below has it
  std::vector<std::vector<ValueMap>> values;    // [blend][channel]; blend 0 is that of the carried matches
  std::vector<std::vector<float>> floor;        // [iteration][family]: mean squared distance
  std::vector<std::vector<FinishMaps>> finish;  // [channel][round]
};

}  // namespace terrazzo::solid_optimize
