// Penalized maximum likelihood on a grid of sizes finer than the requested classes.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/sizes/unfolding/model.h"
#include "nodes/sizes/unfolding/observation.h"
#include "nodes/sizes/unfolding/smooth_poisson.h"

namespace terrazzo::unfolding {

// Each class is divided into equal bins. Sizes are uniform within a bin, whatever the K matrix's averaging.
// Log densities are smooth in the square root of the size, where the distributions of aggregates are closest
// to polynomials, down to small sizes.
struct EmModel {
  std::vector<double> sizes;     // inner edges, mm, from the smallest visible size to d_max
  std::vector<double> profiles;  // fine profile edges, mm, over the same range
  Eigen::MatrixXd fine;          // N_A of fine profile classes = fine · density
  Eigen::MatrixXd coarse;        // N_A of the model's profile classes = coarse · density
  Eigen::MatrixXd reclass;       // N_V of the model's visible classes = reclass · density
  Eigen::VectorXd place;   // position of each inner bin on the unit interval, by the square root of the size
  Eigen::VectorXd width;   // width of each inner bin relative to their mean: density = width · exp(θ)
  std::vector<int> cls;    // visible class of each inner bin
  Eigen::VectorXd volume;  // mean volume of a particle whose size is uniform in the bin's class, mm³
};

EmModel make_em_model(const KMatrix&, const UnfoldModel&, Bed = Bed::None);

struct EmFit {
  std::vector<SmoothPoissonFit> fits;
  Eigen::VectorXd density;  // N_V of the inner bins, per mm³
};

// Fits one color class. `area_error` is the relative error with which the volume fraction is held to the
// class's area fraction. Without profiles, the densities are zero and there are no fits.
EmFit fit_em(const EmModel&, const Observation&, double area, double area_error, const Work&);

// Whether each visible class may be empty at the level of 90 % intervals.
std::vector<char> may_be_empty(const EmModel&, const EmFit&, const Observation&, double area, const Work&);

// Densities of the visible classes for other profile weights (the bootstrap's); `area_ratio`
// multiplies the area fraction.
Eigen::VectorXd draw_em(const EmModel&, const EmFit&, const Observation&, const std::vector<double>& weights,
                        double area, double area_ratio, double area_error, Random&);

}  // namespace terrazzo::unfolding
