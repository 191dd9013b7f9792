// Which profiles a shape is made of.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/profiles.h"
#include "nodes/shape_estimate/outline.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Profiles fit to be drawn on, and why the others are not.
struct Candidates {
  std::vector<Outline> outlines;  // by falling area
  int without_contour = 0, cut_by_border = 0, too_small = 0, faulty = 0, other_class = 0;
  std::string text() const;  // "12 profiles: 3 cut by the border, …"
};

struct CandidateOptions {
  int cls = -1;  // colour or particle class; −1: all
  // Of the √area that a tenth of the whole profiles exceed: smaller sections seldom pass near a particle's
  // centre.
  double smallest = 0.4;
  double crease = 30;  // degrees
};

// Whole, simple contours of enough size. Where contours are as fine as pixels' (half of the larger ones have
// 24 points or more) a profile also needs an area of 30 squares of the median point distance: fewer pixels
// have no shape.
Candidates candidates_of(const Profiles&, const CandidateOptions&, const Work& = {});

// Profiles by id (1…, as in Labels), for better or worse: those cut by the border too. Throws Error
// "bad-profile" for an id that is not there or a contour that is no simple curve.
std::vector<Outline> outlines_by_id(const Profiles&, const std::vector<std::int64_t>& ids, double crease);

// `shapes` times `each` indices into the candidates. `rule`: "largest", from the largest down;
// "representative", the medoids of as many clusters in circularity, aspect ratio, convexity and corners,
// weighted by √area, once the least convex third (what ran together or frayed in segmentation) and the eighth
// least like the common profile have been left out, where that leaves enough; "diverse", each as unlike those
// before as can be. Dealt so that every shape gets rounder and longer ones, by lots drawn from `seed`.
// Profiles serve several shapes only where there are fewer than places.
std::vector<std::vector<int>> choose_profiles(const std::vector<Outline>&, const std::string& rule,
                                              std::size_t shapes, std::size_t each, std::uint64_t seed,
                                              const Work& = {});

}  // namespace terrazzo::shape_estimate
