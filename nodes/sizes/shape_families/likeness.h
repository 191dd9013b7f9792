// Which of a family's shapes the particles of a size have.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::shape_families {

// Shapes of a family may differ with their size: large cells of a tessellation are rounder than small ones.
// Particles of a size have, by preference, the shapes that were given at that size relative to the mean: a
// Gaussian in the logarithm of the size, normalized over the shapes. Shapes of equal size are not preferred.
class Likeness {
 public:
  explicit Likeness(const Shapes&);

  // Probability of a shape for particles of a size, relative to its probability in the family. Both sizes are
  // relative to the mean by number: that of the shape as given, that of the particles.
  double operator()(double shape_size, double particle_size) const;

 private:
  double low_ = 0, high_ = 0;   // range of the logarithm of the shapes' sizes
  std::vector<double> normal_;  // at even steps over this range
};

}  // namespace terrazzo::shape_families
