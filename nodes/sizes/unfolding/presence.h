// Which classes must hold particles according to the counts, without a smoothness assumption.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/work.h"

namespace terrazzo::unfolding {

// counts ~ Poisson(A·x), x ≥ 0. For each class: true if densities with zero in all its bins (cls[j] = class)
// explain the counts almost as well as any densities do, that is, if the log likelihoods differ by less than
// `drop` (half the square of a normal quantile: a one-sided likelihood-ratio test). No smoothness is assumed,
// so that smoothing cannot argue for a class without profiles. `start`: initial densities, > 0.
std::vector<char> may_be_empty(const Eigen::MatrixXd& A, const Eigen::VectorXd& counts,
                               const std::vector<int>& cls, const Eigen::VectorXd& start, double drop,
                               const Work&);

}  // namespace terrazzo::unfolding
