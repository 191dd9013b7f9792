// Segmentation of section photographs into particles.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/segment/figure_ground.h"
#include "nodes/segment/particles.h"

namespace terrazzo::segment {

enum class Method { Auto, Clusters, Regions };

struct SegmentOptions {
  Method method = Method::Auto;
  double likeness = 0.2;  // minimum likeness of a region accepted as a particle
  int clusters = 0;       // 0: automatic
  Hint binder;
  SplitOptions split;
  int color_classes = 1;  // 0: automatic
  std::uint64_t seed = 1;
};

struct Segmentation {
  Labels labels;
  Profiles profiles;
  Ground ground;                     // empty if labels were given
  Method method = Method::Clusters;  // the method used
  double min_area = 0;               // pixels, of the last section
  std::int64_t specks = 0, speck_pixels = 0, holes = 0;
};

// Throws Error "empty-image", "bad-pixels", "one-color", "no-particles".
Segmentation segment(const Image&, const SegmentOptions&, const Work&);
// Measures existing labels. Throws Error "size-mismatch" if they do not match the image, "empty-image",
// "bad-pixels", "bad-labels", "no-particles".
Segmentation measure_labels(const Image&, const Labels&, const SegmentOptions&, const Work&);

}  // namespace terrazzo::segment
