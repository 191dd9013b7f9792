// Maximum penalised likelihood on a finer grid of sizes than the classes asked for.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/unfold/model.h"
#include "nodes/unfold/observation.h"
#include "nodes/unfold/smooth_poisson.h"

namespace terrazzo {

// Each class is divided into equal bins, within which sizes are uniform, whatever the K matrix's averaging.
// Log densities are smooth in the square root of the size: there the laws that aggregates follow are nearest
// to polynomials, down to small sizes.
struct EmModel {
  std::vector<double> sizes;     // inner edges, mm, from the smallest visible size to d_max
  std::vector<double> profiles;  // fine profile edges, mm, over the same range
  Eigen::MatrixXd fine;          // N_A of fine profile classes = fine · density
  Eigen::MatrixXd coarse;        // N_A of the model's profile classes = coarse · density
  Eigen::MatrixXd reclass;       // N_V of the model's visible classes = reclass · density
  Eigen::VectorXd place;         // of the inner bins on the unit interval, by the square root of the size
  Eigen::VectorXd width;         // of the inner bins relative to their mean: density = width · exp(θ)
  std::vector<int> cls;          // visible class of each inner bin
  Eigen::VectorXd volume;        // of a particle of each inner bin once it is uniform in its class, mm³
};

EmModel make_em_model(const KMatrix&, const UnfoldModel&);

struct EmFit {
  std::vector<SmoothPoissonFit> fits;
  Eigen::VectorXd density;  // N_V of the inner bins, per mm³
};

// The fit of one colour class. `area_error`: relative error with which the volume fraction is held to the
// class's area fraction. No profiles: densities of zero and no fits.
EmFit fit_em(const EmModel&, const Observation&, double area, double area_error, const Work&);

// Whether each visible class may hold nothing, for all that 90 % intervals can tell.
std::vector<char> may_be_empty(const EmModel&, const EmFit&, const Observation&, double area, const Work&);

// Densities of the visible classes for profiles of other weights (the bootstrap's); `area_ratio` multiplies
// the area fraction.
Eigen::VectorXd draw_em(const EmModel&, const EmFit&, const Observation&, const std::vector<double>& weights,
                        double area, double area_ratio, double area_error, Random&);

}  // namespace terrazzo
