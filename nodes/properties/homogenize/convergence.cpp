#include "nodes/properties/homogenize/convergence.h"

#include <fmt/format.h>

#include <cmath>

namespace terrazzo::homogenize {

void report(const Convergence& c, double tolerance, const Work& work) {
  const double share = c.residual > 0 && tolerance < 1 ? std::log(c.residual) / std::log(tolerance) : 1;
  work.progress(share, fmt::format("residual {:.1e}", c.residual));
}

Error stalled(const Convergence& c, double tolerance) {
  return Error("not-converged",
               fmt::format("after {} iterations the residual is {:.2g}, above the tolerance of {:.2g}",
                           c.iterations, c.residual, tolerance),
               "allow more iterations, a larger tolerance, or values that differ less")
      .parameter("tolerance");
}

}  // namespace terrazzo::homogenize
