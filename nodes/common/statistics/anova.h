// Analysis of variance of one or two factors.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace terrazzo {

// P(F ≥ f) of the F distribution with a and b degrees of freedom, which need not be whole.
double f_tail(double f, double a, double b);

// All values of one combination of two factors' levels.
struct AnovaCell {
  std::string a, b;    // levels
  double n = 0;        // number of values
  double mean = 0;     // of the values
  double squares = 0;  // Σ (value − mean)²
};

// Groups values by the levels of both factors. The three vectors have equal lengths.
std::vector<AnovaCell> anova_cells(const std::vector<double>& value, const std::vector<std::string>& a,
                                   const std::vector<std::string>& b);

// A row of an analysis of variance. F is (squares / freedom) / (error_squares / error_freedom). F and p are
// NaN if nothing is left for the error (error_freedom 0), or if neither the effect nor its error has any
// variance.
struct AnovaEffect {
  std::string name;  // a factor, or "a × b" for the interaction
  double squares = 0, freedom = 0;
  double error_squares = 0, error_freedom = 0;
  double f = 0, p = 1;
  // Greenhouse and Geisser's ε, at most 1, and p with both degrees of freedom multiplied by it. Only repeated
  // measures need it; elsewhere it is 1.
  double epsilon = 1, corrected_p = 1;
};

// Names of the factors a and b.
using AnovaFactors = std::array<std::string, 2>;

// Analyses of independent values. Two ways: effects of a, of b and of their interaction, each adjusted for
// the preceding ones (the order does not matter if all cells have equally many values). One way: the effect
// of a alone. A factor with one level is left out.
std::vector<AnovaEffect> two_way_anova(const std::vector<AnovaCell>&, const AnovaFactors&);
std::vector<AnovaEffect> one_way_anova(const std::vector<AnovaCell>&, const AnovaFactors&);

// Analysis of repeated measures: every person saw every combination of the levels, and each effect is
// compared with its own interaction with the persons. Row i of `values` holds the means of person i; its
// columns are the combinations in the order a · levels of b + b. Greenhouse and Geisser's correction allows
// effects whose contrasts have unequal variances ("On methods in the analysis of profile data", 1959).
std::vector<AnovaEffect> repeated_anova(const Eigen::MatrixXd& values, int levels_a, int levels_b,
                                        const AnovaFactors&);

}  // namespace terrazzo
