// Chooses the profiles from which shapes are built.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/profiles.h"
#include "nodes/shapes/shape_estimate/outline.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Usable profiles, and the numbers of excluded ones by reason.
struct Candidates {
  std::vector<Outline> outlines;  // by decreasing area
  int without_contour = 0, cut_by_border = 0, too_small = 0, faulty = 0, other_class = 0;
  int hidden = 0;            // partly, by other stones of a surface
  int other_form = 0;        // excluded by CandidateOptions::without
  std::string text() const;  // "12 usable, 3 cut by the border, …"
};

struct CandidateOptions {
  int cls = -1;  // color or particle class; −1: all
  // Smallest √area, relative to the one that a tenth of the uncut profiles exceed: smaller sections seldom
  // pass near a particle's center.
  double smallest = 0.4;
  double crease = 30;             // degrees
  std::vector<int> without = {};  // ids of profiles that are not used, ascending
};

// Uncut, simple contours of sufficient size. If contours are as fine as those of pixels (half of the largest
// quarter have 24 points or more), a profile also needs an area of 30 squares of the median point distance,
// because fewer pixels do not define a shape. At most 1500, the largest.
Candidates candidates_of(const Profiles&, const CandidateOptions&, const Work& = {});

// Profiles by id (1…, as in Labels), including those cut by the border. Throws Error "bad-profile" for an id
// that does not exist or a contour that is not a simple curve.
std::vector<Outline> outlines_by_id(const Profiles&, const std::vector<std::int64_t>& ids, double crease);

// For each of `shapes` shapes, `each` indices into the candidates. `rule`: "largest", in decreasing size;
// "representative", the medoids of clusters in circularity, aspect ratio, convexity and corners, weighted by
// √area, after excluding the least convex third (profiles merged or frayed by segmentation) and the eighth
// least similar to the most common profile, if enough remain; "diverse", each as different from the previous
// ones as possible; "each_size", the usual one of each size. Profiles are dealt randomly (`seed`) so that
// every shape gets rounder and longer ones. A profile is used for several shapes only if there are not
// enough.
std::vector<std::vector<int>> choose_profiles(const std::vector<Outline>&, const std::string& rule,
                                              std::size_t shapes, std::size_t each, std::uint64_t seed,
                                              const Work& = {});

}  // namespace terrazzo::shape_estimate
