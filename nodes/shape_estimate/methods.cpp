#include "nodes/shape_estimate/method.h"

namespace terrazzo::shape_estimate {

const std::vector<EstimateMethod>& estimate_methods() {
  static const std::vector<EstimateMethod> methods{
      {"morphed_generalized_cylinder", 3,
       "a profile swept round another while it morphs between two and more", morphed_generalized_cylinder},
  };
  return methods;
}

}  // namespace terrazzo::shape_estimate
