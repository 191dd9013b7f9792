// From profiles per area to particles per volume.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "nodes/unfold/model.h"
#include "nodes/unfold/observation.h"
#include "runtime/work.h"

namespace terrazzo {

struct UnfoldOptions {
  std::string method = "em";  // "em", "nnls" or "inverse"
  int classes = 0;            // of size; 0: as many as the K matrix has, fewer where profiles are few
  double smallest_visible =
      -1;  // mm, size of the smallest profile that would be seen; < 0: the smallest that was
  Border border = Border::Weights;
  double d_max = 0;          // mm, size of the largest particle; 0: estimated
  double area_fraction = 0;  // where the profiles do not know it; 0: unknown
  bool by_class = false;     // colour class c is of shape c alone (eq. 9), else of all by their probabilities
  int bootstrap = 0;         // repetitions for the intervals
  std::uint64_t seed = 1;    // of the bootstrap
};

// How one colour class was fitted, per visible profile class.
struct UnfoldFit {
  Eigen::VectorXd observed, refitted;  // N_A, per mm²
  Eigen::VectorXd density;             // N_V, per mm³, of the visible classes
  double negative = 0;                 // Σ |N_V| that `inverse` had below zero, relative to Σ |N_V|
  double freedom = 0;                  // parameters that the profiles determine
  double jumps = 0;                    // that `em` takes the density to have, mean over its fits
};

struct UnfoldResult {
  SizeDistribution distribution;
  UnfoldModel model;
  std::vector<UnfoldFit> fits;  // a colour class each
  Observations observations;
  double condition = 0;  // of the model matrix, columns scaled to length one
};

// Classes that n profiles can tell apart: 2·n^⅓ (Terrell and Scott 1985).
int classes_for(std::size_t profiles);

// The scale of the largest particle by maximum likelihood over multiples of the largest profile (ERRATA of
// eq. 7: the largest section seen underestimates it), from 1 to 1.6 in steps of 2 %.
double estimate_d_max(const Observations&, const KMatrix&, int classes, double smallest_visible, const Work&);

// `em`: penalised maximum likelihood of Poisson counts on a finer grid of sizes, log densities smooth to the
// degree that the counts ask for, with jumps where they do. `nnls`: densities ≥ 0 of least squared error,
// every class weighted by the counting error of its profiles. Both hold the volume fraction Σ N_V·V to the
// area fraction of the profiles (V_V = A_A), which is known far better than any class. `inverse` solves N_A =
// M·N_V (Jagnow et al. 2004, eq. 8, 12) and sets negative densities to zero. Where the area observed is
// unknown Σ N_V is 1 and the volume fraction 0. Throws Error "no-profiles", "bad-profiles", "bad-kmatrix",
// "too-few-profiles", "singular", "unstable" (more than full), "nothing-visible", "too-small" (d_max).
UnfoldResult unfold(const Profiles&, const KMatrix&, const UnfoldOptions&, const Work&);

}  // namespace terrazzo
