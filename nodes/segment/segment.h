// Segmentation of photographs of sections into particles.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/segment/figure_ground.h"
#include "nodes/segment/particles.h"

namespace terrazzo {

enum class Method { Auto, Clusters, Regions };

struct SegmentOptions {
  Method method = Method::Auto;
  double likeness = 0.2;  // least of a region that is taken for a particle
  int clusters = 0;       // 0: found
  Hint binder;
  SplitOptions split;
  int color_classes = 1;  // 0: found
  std::uint64_t seed = 1;
};

struct Segmentation {
  Labels labels;
  Profiles profiles;
  Ground ground;                     // empty where labels were given
  Method method = Method::Clusters;  // the one used
  double min_area = 0;               // pixels, of the last section
  std::int64_t specks = 0, speck_pixels = 0, holes = 0;
};

// Throws Error "empty-image", "bad-pixels", "one-colour", "no-particles".
Segmentation segment(const Image&, const SegmentOptions&, const Work&);
// Measures labels made elsewhere. Throws Error "unequal-size" where they do not fit the image.
Segmentation measure_labels(const Image&, const Labels&, const SegmentOptions&, const Work&);

}  // namespace terrazzo
