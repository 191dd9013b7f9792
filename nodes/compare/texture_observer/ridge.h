// A regularized linear classifier of two classes.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::texture_observer {

// Ridge regression of −1 and 1 on features in units of their standard deviation. The penalty is the one of
// seven with the least squared error on strips that were left out in turn, in closed form.
class Ridge {
 public:
  // One row per example, at least one of each class, classes equally frequent. `y`: −1 or 1. `strip`: rows of
  // equal number are left out together; if there is only one strip, the penalty is the number of rows.
  Ridge(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const std::vector<int>& strip,
        const Work& work = {});

  // One per row of x: negative for the class −1.
  Eigen::VectorXd scores(const Eigen::MatrixXd& x) const;

 private:
  Eigen::RowVectorXd mean_, scale_;
  Eigen::VectorXd weights_;
};

}  // namespace terrazzo::texture_observer
