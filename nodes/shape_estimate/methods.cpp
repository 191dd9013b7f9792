#include "nodes/shape_estimate/method.h"

namespace terrazzo::shape_estimate {

const std::vector<EstimateMethod>& estimate_methods() {
  static const std::vector<EstimateMethod> methods{
      {"spherical_harmonics", 1, 0,
       "a sphere whose radius is a random function of the direction with the profiles' spectrum, another one "
       "each",
       spherical_harmonics},
      {"csg", 3, 3, "what three extruded profiles have in common: they are its silhouettes", csg, 6, true},
      {"generalized_cylinder", 2, 2, "half of one profile swept round another", generalized_cylinder},
      {"morphed_generalized_cylinder", 3, 0,
       "a profile swept round another while it morphs between two and more", morphed_generalized_cylinder},
      {"fit", 3, 0,
       "bodies that the other methods start and a search deforms until their random sections have the joint "
       "distribution of circularity, total curvature, aspect ratio, convexity, corners, symmetry and "
       "curvature "
       "of all the profiles",
       nullptr},
  };
  return methods;
}

}  // namespace terrazzo::shape_estimate
