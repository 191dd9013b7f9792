// How much two results differ, beside what sampling alone would make them differ.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "nodes/common/plot.h"
#include "nodes/data/image.h"
#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo {

// One compared number. `tolerance` is the half width of the 95 % interval of b − a if both were samples of
// one thing; NaN where the noise is unknown, and then nothing exceeds it.
struct ComparedNumber {
  std::string measure, item, unit;
  double lower = 0, upper = 0;  // of a bin, mm; both 0 where there is none
  double a = 0, b = 0, tolerance = 0;
  bool exceeds() const;
};

struct ColorPair {
  std::string name;
  Vec3f a, b;        // scene-linear
  double delta = 0;  // distance in Oklab
};

struct Comparison {
  std::vector<ComparedNumber> numbers;
  std::vector<ColorPair> colors;
  std::vector<Plot> plots;  // a's series first, then b's, not named
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
};

struct CompareChoice {
  bool size_classes = true, area_fraction = true, color = true;
  bool circularity = true, total_curvature = true;                                       // profiles
  bool bands = true, patches = true, two_point = true, lineal_path = true, seam = true;  // pictures
  int classes = 10;
  double smallest = 0;  // profiles of a smaller diameter √(4A/π) are left out of size_classes, mm
};

// size_classes: weighted N_A in equal bins of √A up to the larger of both sets' largest profiles; noise:
// Poisson, from the rate of both sets together and their mean squared weight, with continuity correction. L1
// is Σ|b − a| / Σ a. Where an observed area is unknown, shares of the number are compared instead, and a
// warning says so. area_fraction: noise from Var ≈ Σ w·A² / area² (profiles of a Boolean model; an upper
// bound where particles repel). color: means in Oklab, of profiles by their visible area; noise from their
// spread, at least 0.02, a just visible step. circularity (A/P²) and total_curvature of whole profiles with
// outlines, where both sets have any: means, and the Kolmogorov–Smirnov distance of the distributions. Throws
// Error "no-profiles" where a set is empty, "bad-profile" where an area or weight is not a number ≥ 0.
Comparison compare(const Profiles& a, const Profiles& b, const CompareChoice&);

// size_classes: N_V summed over shapes and colour classes; where the class edges differ, both are re-classed
// to `classes` equal bins, each class spread evenly over its sizes. Noise from the 90 % intervals. L1 as
// above. Throws Error "no-classes".
Comparison compare(const SizeDistribution& a, const SizeDistribution& b, const CompareChoice&);

// color: means in Oklab, and the earth mover's distance of each channel's histogram (mean difference of
// quantiles), with the distance between halves of one picture as its tolerance. In the same way, but by
// halves of a: of lightness bands of a steerable pyramid, two-point correlation and lineal path of the darker
// half up to 32 pixels; of Oklab: patches of 7 × 7 pixels, as distributions and each beside its nearest; and
// steps across the wrap over steps inside (seam), without a tolerance. Textures need 48 pixels a side. Throws
// Error "no-pixels", "bad-pixels".
Comparison compare(const Image& a, const Image& b, const CompareChoice&, const Work& = {});

// Their parts: compare_textures.cpp, compare_outlines.cpp.
void compare_textures(const Image& a, const Image& b, const CompareChoice&, Comparison&, const Work&);
// `measure`: circularity or total_curvature.
void compare_outlines(const Profiles& a, const Profiles& b, const std::string& measure, double smallest,
                      Comparison&);

// Columns: measure, item, unit, lower mm, upper mm, a, b, difference, tolerance, exceeds.
Table table_of(const Comparison&);
// Bars of every binned number, bars of the rest, swatches of the colours.
Image figure_of(const Comparison&, const std::string& name_a, const std::string& name_b);

}  // namespace terrazzo
