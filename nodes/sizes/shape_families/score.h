// How well families of particle shapes predict profiles that were held out.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_families {

struct Family {
  std::string name;
  const Shapes* shapes = nullptr;
  const KMatrix* kmatrix = nullptr;  // of these shapes
};

struct ScoreOptions {
  int folds = 5;                 // each profile is predicted from the other folds
  std::size_t sections = 3000;   // of each family, whose outlines are measured
  double smallest_visible = -1;  // mm, as in Unfold; < 0: the smallest profile
  int bootstrap = 40;            // repetitions for the interval of N_V; 0: none
  std::uint64_t seed = 1;
};

struct FamilyScore {
  // Mean log predictive density per profile: of sizes, in 1/mm, and of outlines given the sizes. Weighted by
  // the number of profiles that each represents.
  double sizes = 0, outlines = 0;
  // Sum of both over the best family's, ≤ 0, and the standard error of this difference over profiles.
  double behind = 0, error = 0;
  bool plausible = false;             // at most two standard errors behind
  double N_V = 0, low = 0, high = 0;  // per mm³ and its 90 % interval; relative if the area is unknown
  double mean_size = 0;               // by number, mm
  double goodness_of_fit = 0;         // χ² per degree of freedom of the refitted N_A
};

struct Scores {
  std::vector<FamilyScore> families;
  std::size_t best = 0;
  std::size_t profiles = 0, outlines = 0;  // number of profiles predicted, and of those with an outline
  bool relative = false;                   // N_V is relative
};

// Sizes and outlines of each fold are predicted from the sizes of the other folds: these are unfolded (`em`)
// with the family's K matrix. A profile of size s shows a particle of size s/r with the density n(s/r)·s/r²
// of the sections of relative size r, times the likeness of the section's shape to particles of that size.
// The outlines of these sections, blurred alike, predict the profile's by a kernel density (Geisser and Eddy
// 1979: predictive sample reuse). A twentieth of the probability goes to outlines of any kind, a hundredth to
// sizes of any kind, so that a few wrong profiles do not decide. Color classes are pooled. Throws Error
// "wrong-count" if a K matrix has other shapes, "too-few-profiles", and the errors of Unfold.
Scores score_families(const Profiles&, const std::vector<Family>&, const ScoreOptions&, const Work&);

}  // namespace terrazzo::shape_families
