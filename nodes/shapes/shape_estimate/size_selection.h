// Which sections of a body are among profiles that are larger than a limit.
#pragma once

#include <vector>

#include "nodes/shapes/shape_estimate/section_sample.h"

namespace terrazzo::shape_estimate {

// Particles of many sizes have one shape here. Among their profiles above a limit, sections far from a
// particle's center are rarer than among all sections of one body, because only the largest particles show
// them. Estimates the distribution of particle sizes from the profiles and weights sections accordingly.
class SizeSelection {
 public:
  // Particles of one size, whose profiles have a mean root area of `mean`, mm. Sections below `smallest`,
  // 0 … 1, are not seen. It is relative to the root area that a tenth of the sections exceed.
  SizeSelection(double smallest, double mean) : smallest_(smallest), mean_(mean) {}

  // Particles of any sizes. `root_area`: of the profiles, all that are larger than the smallest of them, mm.
  // `typical`: sections of bodies that are like the particles, whose root areas relative to their mean serve
  // as those of any particle. Sizes in logarithmic classes follow by maximum likelihood with expectation
  // maximization (Dempster, Laird, Rubin 1977) for observations above a limit.
  SizeSelection(const std::vector<double>& root_area, const std::vector<std::vector<CutProfile>>& typical);

  // Multiplies the weight of each section of a body by the probability that it is seen, and removes those
  // that are not. Gives each section the scale of one of the particles that show it above the limit; the
  // scales have the distribution of the particles.
  void apply(std::vector<CutProfile>&) const;

 private:
  double smallest_ = 0, mean_ = 0;
  double limit_ = 0;  // root area of the smallest profile, mm
  // The probability that a section is seen whose root area is e^(first_ + k·kStep) of the body's mean. It
  // rises, from 0 to 1.
  std::vector<double> seen_;
  double first_ = 0;
};

}  // namespace terrazzo::shape_estimate
