// Features of a crop that mean something together.
#pragma once

#include <string>
#include <vector>

namespace terrazzo::texture_observer {

struct FeatureGroup {
  std::string name;
  int first = 0, count = 0;  // columns of the feature matrix
};

}  // namespace terrazzo::texture_observer
