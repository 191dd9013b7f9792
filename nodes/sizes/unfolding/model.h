// The linear model of unfolding: the profile densities that a size distribution shows.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "nodes/data/indices.h"
#include "nodes/data/kmatrix.h"
#include "nodes/sizes/unfolding/hiding.h"

namespace terrazzo::unfolding {

// Sizes and profiles in equal classes of [0, d_max], shapes mixed by their probabilities at each size
// (Jagnow et al. 2004, eq. 10–12), or as a surface shows them. Classes below `first` show no profile as large
// as `smallest_visible` and are left out.
struct UnfoldModel {
  std::vector<double> edges;          // n + 1, mm; edge `first` is raised to smallest_visible
  int equal = 0;                      // number of classes before the first visible one was divided
  int first = 0;                      // first visible class
  std::vector<double> profile_edges;  // of the visible classes, mm; the first ≥ smallest_visible
  Eigen::MatrixXd matrix;             // visible classes: N_A (per mm²) = matrix (mm) · N_V (per mm³)
  Eigen::VectorXd volume;             // mean volume of a particle of each visible class, mm³
  bool upper_edge = false;            // sizes at the upper edge of their class rather than uniform

  int classes() const { return count_of(edges) - 1; }
  int visible() const { return classes() - first; }
};

// If the sizes of the profiles are given, the first visible class is divided geometrically where its edges
// differ by more than a factor of two, as far as the lowest part holds as many profiles as a class does on
// average: sizes in a class count as uniform, and the smallest particles are the most frequent ones. Throws
// Error "bad-kmatrix" if the K matrix is incomplete, "nothing-visible" if smallest_visible ≥ d_max.
UnfoldModel make_model(const KMatrix&, int classes, double d_max, double smallest_visible,
                       const std::vector<double>& profiles = {}, Bed = Bed::None);

// The share of each shape among particles of this size, in mm.
std::vector<double> shape_shares(const KMatrix&, double size);

// The model matrix for other classes: a row per profile class, a column per size class. Of a surface,
// only the mean height of the shapes matters (hiding.h).
Eigen::MatrixXd model_matrix(const KMatrix&, const std::vector<double>& profile_edges,
                             const std::vector<double>& size_edges, bool upper_edge, Bed = Bed::None);

// Weighted counts of sizes in the classes between `edges`; sizes outside are ignored.
struct Counts {
  Eigen::VectorXd sum, squares;  // Σw and Σw² per class
};
Counts count(const std::vector<double>& sizes, const std::vector<double>& weights,
             const std::vector<double>& edges);

}  // namespace terrazzo::unfolding
