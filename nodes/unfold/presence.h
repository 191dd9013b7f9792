// Which classes the counts themselves show to hold particles.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/work.h"

namespace terrazzo {

// counts ~ Poisson(A·x), x ≥ 0. Per class: true where nothing in the bins j with cls[j] = class explains the
// counts almost as well as any densities do: log likelihoods less than `drop` apart (half of a normal
// quantile's square: a one-sided test by likelihood ratio). No smoothness is assumed, so that it cannot speak
// for a class that nobody has seen. `start`: densities to begin with, > 0.
std::vector<char> may_be_empty(const Eigen::MatrixXd& A, const Eigen::VectorXd& counts,
                               const std::vector<int>& cls, const Eigen::VectorXd& start, double drop,
                               const Work&);

}  // namespace terrazzo
