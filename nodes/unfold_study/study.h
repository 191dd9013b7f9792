// How well each method of unfolding recovers known sizes, over repeated observations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/size_distribution.h"
#include "runtime/work.h"

namespace terrazzo::unfold_study {

struct StudyOptions {
  // "em", "nnls", "inverse", and "equation 4": inverse with all of a class at its upper edge, as in the
  // paper.
  std::vector<std::string> methods;
  int repetitions = 10;
  double profiles = 1200;  // expected number seen by each repetition
  int sections = 10;       // that they are spread over
  int classes = 10;
  bool known_d_max = false;  // classes end at the largest size there is, else at the estimate
  int bootstrap = 0;         // of em and nnls, for the coverage of their intervals; 0: not asked for
  std::uint64_t seed = 1;
};

struct MethodResult {
  std::string method;
  double error = 0, error_of_mean = 0;  // Σ|ΔN_V|/ΣN_V, mean over the repetitions and its standard error
  double total = 0;                     // ΣN_V estimated / true, mean
  double coverage = 0;             // share of 90 % intervals that hold the truth; NaN where there are none
  int refused = 0;                 // repetitions that ended in an error: they have no part in the means
  std::vector<double> edges, N_V;  // of the first repetition that was not refused
};

// Every method sees the same profiles. Errors are by class of the estimate, against the truth within the same
// edges; particles outside of them count as missed.
std::vector<MethodResult> study(const SizeDistribution& truth, const KMatrix&, const StudyOptions&,
                                const Work&);

}  // namespace terrazzo::unfold_study
