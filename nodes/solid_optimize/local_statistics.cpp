#include "nodes/solid_optimize/local_statistics.h"

namespace terrazzo::solid_optimize {

ValueMap::ValueMap(const std::vector<float>& values, Quantiles target)
    : made_(std::make_shared<Made>(std::move(target))) {
  Remap::Counts counts(Remap::kBins, 0);
  made_->map.count(values.data(), values.size(), counts);
  made_->map.finish(counts);
}

}  // namespace terrazzo::solid_optimize
