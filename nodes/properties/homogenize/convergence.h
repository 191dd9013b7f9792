// How far an iterative solver has come.
#pragma once

#include "graph/diagnostic.h"
#include "runtime/work.h"

namespace terrazzo::homogenize {

struct Accuracy {
  double tolerance;  // of the relative residual
  int iterations;    // at most
};

struct Convergence {
  int iterations = 0;
  double residual = 0;  // relative to that of the start, or the error that is too large
};

// Shows the residual, with the progress that its logarithm has made toward the tolerance.
void report(const Convergence&, double tolerance, const Work&);

// Error "not-converged", with the residual.
Error stalled(const Convergence&, double tolerance);

}  // namespace terrazzo::homogenize
