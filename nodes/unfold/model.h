// The linear model of unfolding: what profile densities a size distribution shows.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "nodes/data/kmatrix.h"

namespace terrazzo {

// Sizes and profiles in equal classes of [0, d_max], several shapes mixed by their probabilities (Jagnow et
// al. 2004, eq. 10–12). Classes below `first` show no profile as large as `smallest_visible` and are left
// out.
struct UnfoldModel {
  std::vector<double> edges;          // n + 1, mm; that of `first` raised to smallest_visible
  int first = 0;                      // first visible class
  std::vector<double> profile_edges;  // of the visible classes; the first starts at smallest_visible
  Eigen::MatrixXd matrix;  // N_A (per mm²) of visible classes = matrix (mm) · N_V (per mm³) of those
  Eigen::VectorXd volume;  // mean volume of a particle of each visible class, mm³
  bool upper_edge = false;

  int classes() const { return static_cast<int>(edges.size()) - 1; }
  int visible() const { return classes() - first; }
};

// Throws Error "bad-kmatrix" where it lacks what is needed, "nothing-visible" where smallest_visible ≥ d_max.
UnfoldModel make_model(const KMatrix&, int classes, double d_max, double smallest_visible);

// The same for other profile classes: rows between `profile_edges`, columns as in the model.
Eigen::MatrixXd model_matrix(const KMatrix&, const std::vector<double>& profile_edges,
                             const std::vector<double>& size_edges, bool upper_edge);

// Weighted counts of sizes in the classes between `edges`; sizes outside are left out.
struct Counts {
  Eigen::VectorXd sum, squares;  // Σw and Σw² per class
};
Counts count(const std::vector<double>& sizes, const std::vector<double>& weights,
             const std::vector<double>& edges);

}  // namespace terrazzo
