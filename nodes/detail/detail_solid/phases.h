// What a photograph shows beyond flat colors, separately for its binder and for groups of its particles.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/indices.h"
#include "nodes/data/labels.h"
#include "nodes/detail/residual/outline_depth.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// Pixels are ordered as in Image.
struct Phases {
  int width = 0, height = 0, sections = 1;
  std::vector<Vec3f> offset;       // from the flat color, as in Detail
  std::vector<std::int8_t> phase;  // −1: not used, 0: binder, g: group of particles
  std::vector<Vec3f> group_color;  // of groups 1, 2 …; mean of their profiles' colors by area, scene-linear
  std::vector<Vec3f> profile_color;  // of label k at k − 1; median, zero without used pixels; scene-linear
  std::vector<std::size_t> pixels;   // used pixels of each phase
  // Deviation of the camera's noise that was taken out, in the unit of each phase's offsets; empty: none.
  std::vector<float> noise;
  std::vector<std::int8_t> zone;  // of the binder's pixels, see zones.h; 0 elsewhere; empty without zones
  double outliers = 0;            // fraction of the binder's pixels that are particles missed by the labels

  std::size_t plane() const { return pixels_in(width, height); }
};

struct PhaseOptions {
  int edge = 1;         // pixels on each side of an outline that are not used
  double specks = 6;    // limit for binder pixels in robust standard deviations from the binder's median; 0:
                        // none
  int groups = 3;       // most groups of particles
  double softness = 0;  // standard deviation of the blur of outlines, pixels
  // Of the solid's binder, scene-linear; none: the mean of its pixels that are used.
  std::optional<Vec3f> binder = {};
  const Labels* mask = nullptr;  // not 0: pixels that are not used; none: all are
  std::uint64_t seed = 1;
};

// Mean of colors or offsets; zero without any.
struct Mean {
  Vec3 sum = Vec3::Zero();
  double count = 0;
  void add(const Vec3f& v) {
    sum += v.cast<double>();
    ++count;
  }
  Vec3f value() const { return (sum / std::max(count, 1.0)).cast<float>(); }
};

// Throws Error "empty-image", "size-mismatch", "bad-pixels", "bad-labels".
void check_photograph(const Image&, const Labels&);

// The flat color of a pixel is the median of its profile's used pixels, or the mean of the section's binder,
// moved so that the mean of all sections is the solid's binder, blurred as the photograph blurs outlines.
// Profiles are grouped by color (k-means in Oklab, weighted by area); there are fewer groups if one would
// have too few pixels for a texture. The photograph must have passed check_photograph.
Phases find_phases(const Image&, const Labels&, const PhaseOptions&, const Work& = {});

// Of all sections, one after the other, in the order of the pixels of the phases.
residual::Outlines outlines_of(const Phases&, const Labels&);

}  // namespace terrazzo::detail_solid
