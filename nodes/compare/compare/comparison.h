// Compares two results, with the differences expected from sampling noise.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "nodes/common/plot/plot.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::compare {

// One compared number. `tolerance` is the half-width of the 95 % interval of b − a, assuming that both are
// samples of the same material; NaN if the noise is unknown, and then nothing exceeds it.
struct ComparedNumber {
  std::string measure, item, unit;
  double lower = 0, upper = 0;  // edges of a bin, mm; both 0 if there is none
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
  std::vector<Plot> plots;  // a's series first, then b's, without names
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
};

struct CompareOptions {
  bool size_classes = true, area_fraction = true, color = true;
  bool circularity = true, total_curvature = true;  // profiles
  bool two_point = true, lineal_path = true;        // images, and profiles with labels
  bool bands = true, patches = true, seam = true;   // images
  int classes = 10;
  double smallest = 0;  // mm; size_classes omits profiles with a smaller diameter √(4A/π)
};

// size_classes: weighted N_A in equal bins of √A up to the largest profile of both sets. The noise is
// Poisson, from the pooled rate and the mean squared weight of both sets, with continuity correction. L1 is
// Σ|b − a| / Σ a. If an observed area is unknown, compares shares of the total number instead and warns.
// area_fraction: noise from Var ≈ Σ w·A² / area² (profiles of a Boolean model; an upper bound if particles
// repel). color: means in Oklab, of profiles weighted by their visible area. The noise comes from their
// spread and is at least 0.02, a just visible step. circularity (A/P²), total_curvature: whole profiles with
// outlines, if both sets have any. Compares the means, and the distributions by the Kolmogorov–Smirnov
// distance. Throws Error "no-profiles" if a set is empty, "bad-profile" if an area or weight is not a number
// ≥ 0.
Comparison compare(const Profiles& a, const Profiles& b, const CompareOptions&);

// size_classes: N_V summed over shapes and color classes. If the class edges differ, both are redistributed
// to `classes` equal bins, assuming that each class is uniform over its sizes. The noise comes from the 90 %
// intervals. L1 as above. Throws Error "no-classes".
Comparison compare(const SizeDistribution& a, const SizeDistribution& b, const CompareOptions&);

// color: means in Oklab, and the earth mover's distance (mean difference of quantiles) of each channel's
// histogram. The tolerance of the latter is the larger distance between halves of a or halves of b. The
// texture measures need images of at least 48 pixels per side; their tolerance is the difference between
// halves of a. bands: lightness in a steerable pyramid. two_point, lineal_path: statistics of the darker half
// up to 32 pixels. patches: 7 × 7 pixels in Oklab, as distributions and by their nearest patch in the other
// image. seam: step across the wrap / mean step inside, without a tolerance. Throws Error "no-pixels",
// "bad-pixels".
Comparison compare(const Image& a, const Image& b, const CompareOptions&, const Work& = {});

// How particles and binder are arranged in the sections of two sets: two_point is the probability that both
// ends of a segment are in particles, lineal_path that all of it is in one particle, or in the binder
// (Torquato 2002, 2.1 and 2.4), along rows and columns up to four mean intercepts or a quarter of a side.
// Pixels below 0 were not observed: no segment ends there, nor does one of two_point start there.
// Compares the largest difference at any distance. Its tolerance is the 95th percentile of the same
// difference between one section and the others of the set with more sections (below four, quarters of
// sections), scaled to the areas of both sets.
void compare_phases(const Labels& a, const Labels& b, const CompareOptions&, Comparison&, const Work&);

// Parts of the above, in compare_textures.cpp and compare_outlines.cpp.
void compare_textures(const Image& a, const Image& b, const CompareOptions&, Comparison&, const Work&);
// `measure` is circularity or total_curvature.
void compare_outlines(const Profiles& a, const Profiles& b, const std::string& measure, double smallest,
                      Comparison&);

// Columns: measure, item, unit, lower mm, upper mm, a, b, difference, tolerance, exceeds.
Table table_of(const Comparison&);
// Bars of the binned numbers and of the area fractions, color swatches, and the plots.
Image figure_of(const Comparison&, const std::string& name_a, const std::string& name_b);

}  // namespace terrazzo::compare
