// Analysis of variance of the answers of a study.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::study_anova {

// P(F ≥ f) of the F distribution with a and b degrees of freedom.
double f_tail(double f, double a, double b);

struct Effect {
  std::string name;  // "method", "shape", "method × shape", "residual"
  double squares = 0;
  double freedom = 0;
  double f = 0, p = 1;  // NaN for the residual
};

// Two-way analysis of variance with interaction, each effect adjusted for the preceding ones (the order does
// not matter for balanced answers). A factor with one level is left out. Throws Error "too-few-answers" if no
// degree of freedom remains for the residual.
std::vector<Effect> two_way(const std::vector<double>& value, const std::vector<std::string>& method,
                            const std::vector<std::string>& shape);

}  // namespace terrazzo::study_anova
