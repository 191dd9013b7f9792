// Measures how well each unfolding method recovers known sizes, over repeated observations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/size_distribution.h"
#include "runtime/work.h"

namespace terrazzo::unfold_study {

enum class LargestSize {
  Estimated,      // as Unfold estimates it
  Known,          // the largest true size
  LargestProfile  // the size whose largest section is the largest profile (Jagnow et al. 2004, eq. 7)
};

struct StudyOptions {
  // "em", "nnls", "inverse", and "equation 4": inverse with all sizes of a class at its upper edge,
  // as in the paper.
  std::vector<std::string> methods;
  int repetitions = 10;
  double profiles = 1200;  // expected number of profiles per repetition
  int sections = 10;       // number of sections that the profiles are spread over
  int classes = 10;
  LargestSize largest = LargestSize::Estimated;  // where classes end
  int bootstrap = 0;  // repetitions for the intervals of em and nnls; 0: no coverage
  std::uint64_t seed = 1;
};

struct MethodResult {
  std::string method;
  double error = 0, error_of_mean = 0;  // Σ|ΔN_V|/ΣN_V, mean over the repetitions and its standard error
  double total = 0;                     // ΣN_V estimated / true, mean
  // Share of 90 % intervals that contain the truth, among classes whose particles show at least one of the
  // expected profiles; NaN without intervals.
  double coverage = 0;
  std::vector<double> class_coverage;  // the same by class
  int refused = 0;                     // repetitions that ended in an error; excluded from the means
  std::vector<double> edges, N_V;      // of the first repetition that was not refused
};

// Every method sees the same profiles. Errors are summed over the classes of the estimate and compare it with
// the truth within the same edges; particles outside these edges are errors.
std::vector<MethodResult> study(const SizeDistribution& truth, const KMatrix&, const StudyOptions&,
                                const Work&);

}  // namespace terrazzo::unfold_study
