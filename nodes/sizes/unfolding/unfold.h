// Unfolding: particles per volume from profiles per area.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "nodes/sizes/unfolding/model.h"
#include "nodes/sizes/unfolding/observation.h"
#include "runtime/work.h"

namespace terrazzo::unfolding {

// Relative error of the area fraction: small compared with that of any class, so that the solid's volume
// fraction matches the photograph.
inline constexpr double kFractionError = 0.005;

enum class Method { Em, Nnls, Inverse };

enum class Types {
  Mixed,   // every color class has its own shapes and those without a class, by probability
  ByClass  // color class c has only shape c (eq. 9)
};

struct UnfoldOptions {
  Method method = Method::Em;
  int classes = 0;  // number of size classes; 0: as many as the K matrix has, fewer if profiles are few
  // Size of the smallest profile that can be seen, mm; < 0: the smallest observed, or 1.3 times as much for
  // loose stones; of a surface, at most 0.8 of the largest, and at least half of the silhouettes stay.
  double smallest_visible = -1;
  Border border = Border::Weights;
  double d_max = 0;          // size of the largest particle, mm; 0: estimated
  double area_fraction = 0;  // overrides that of the profiles; 0: use theirs
  Types types = Types::Mixed;
  int bootstrap = 0;       // number of repetitions for the intervals
  std::uint64_t seed = 1;  // random seed of the bootstrap
};

// The fit of one color class, per visible profile class.
struct UnfoldFit {
  Eigen::VectorXd observed, refitted;  // N_A, per mm²
  Eigen::VectorXd density;             // N_V, per mm³, of the visible classes
  double negative = 0;  // Σ |N_V| over the negative densities of `inverse`, relative to Σ |N_V|
  double freedom = 0;   // number of parameters that the profiles determine
  double jumps = 0;     // number of jumps of the density in `em`, weighted mean over its fits
};

struct UnfoldResult {
  SizeDistribution distribution;
  UnfoldModel model;
  std::vector<UnfoldFit> fits;  // one per color class
  Observations observations;
  double condition = 0;  // condition number of the model matrix, columns scaled to unit length
};

// Number of classes that n profiles support: 2·n^⅓ (Terrell and Scott 1985).
int classes_for(std::size_t profiles);

// The K matrix of a color class: the class's shapes and those without a class by probability, or only the
// class's own shape (eq. 9). Throws Error "no-shape-of-class".
KMatrix kmatrix_of(const KMatrix&, Types, std::size_t cls);

// Whether color classes have different K matrices.
bool depends_on_class(const KMatrix&, Types);

// Size of the largest particle of all color classes: the smallest multiple of the largest profile, from 1 to
// 1.6 in steps of 2 %, whose log likelihood is within a standard error of the maximum. The likelihood rises
// steeply and then stays flat, because particles that are too few to be seen cannot be excluded. The largest
// profile itself underestimates it (errata 3 in docs/errata.md, 2004 eq. 7).
double estimate_d_max(const Observations&, const KMatrix&, Types, int classes, double smallest_visible,
                      const Work&);

// `em`: penalized maximum likelihood of Poisson counts on a finer grid of sizes; the counts choose the
// smoothness and the jumps of the log density. `nnls`: densities ≥ 0 with the least squared error, each class
// weighted by the counting error of its profiles. Both hold the volume fraction Σ N_V·V to the area fraction
// of the profiles (V_V = A_A), which is known far better than any class. `inverse` solves N_A = M·N_V (Jagnow
// et al. 2004, eq. 8, 12) and sets negative densities to zero. If the observed area is unknown, Σ N_V is 1
// and the volume fraction 0. Profiles of a surface are silhouettes: sizes are those of whole silhouettes,
// stones hide each other (hiding.h), and the volume fraction of loose stones is drawn toward
// kLooseFraction afterwards, unless area_fraction gives it. A volume fraction of 1 to 1.02 is scaled to 1.
// Throws Error "no-profiles", "bad-profiles", "bad-kmatrix", "too-few-profiles", "singular", "unstable"
// (particles would fill more than the volume), "nothing-visible", "too-small" (d_max).
UnfoldResult unfold(const Profiles&, const KMatrix&, const UnfoldOptions&, const Work&);

}  // namespace terrazzo::unfolding
