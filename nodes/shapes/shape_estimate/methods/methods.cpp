#include "nodes/shapes/shape_estimate/methods/method.h"

namespace terrazzo::shape_estimate {

const std::vector<EstimateMethod>& estimate_methods() {
  static const std::vector<EstimateMethod> methods{
      {"spherical_harmonics", 1, 0,
       "a sphere whose radius is a random function of direction with the profiles' spectrum, drawn "
       "independently for each shape",
       spherical_harmonics},
      {"csg", 3, 3, "the intersection of three extruded profiles, which are its silhouettes", csg, 6, true},
      {"generalized_cylinder", 2, 2, "half of one profile swept around another", generalized_cylinder},
      {"morphed_generalized_cylinder", 3, 0,
       "a profile swept around another while it morphs between two or more", morphed_generalized_cylinder},
      {"inflation", 1, 1,
       "a body with one profile as its silhouette and faces as uneven as the profiles, for stones of a "
       "surface",
       inflation, 0, false, true},
      {"faceted", 1, 1,
       "a convex body with flat faces whose silhouette has the sides of one profile, for crushed stones of a "
       "surface",
       faceted, 0, false, true},
      {"fit", 3, 0,
       "bodies from the other methods, deformed until their random sections have the joint distribution of "
       "circularity, total curvature, aspect ratio, convexity, corners, symmetry and curvature of all "
       "profiles",
       nullptr},
  };
  return methods;
}

}  // namespace terrazzo::shape_estimate
