// Segmentation of section photographs into particles.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/photograph/marks/ignored.h"
#include "nodes/photograph/marks/objects.h"
#include "nodes/photograph/segment/color/figure_ground.h"
#include "nodes/photograph/segment/color/particles.h"
#include "nodes/photograph/segment/measure/tilt.h"
#include "nodes/photograph/segment/measure/view.h"
#include "nodes/photograph/segment/network/network.h"
#include "nodes/photograph/segment/scribbles/scribbles.h"

namespace terrazzo::segment {

enum class Method { Auto, Clusters, Network, Scribbles, Both };

struct SegmentOptions {
  Method method = Method::Auto;
  int clusters = 0;  // 0: automatic
  Hint binder;
  SplitOptions split;
  const Network* network = nullptr;  // of Method::Auto and Method::Network; none: the built-in one
  double network_scale = 0;          // of the picture that the network sees, up to 1; 0: by its sharpness
  Scribbles scribbles;        // needed by Method::Scribbles, which Method::Auto chooses if there are any
  double min_confidence = 0;  // particles below it are dropped
  IgnoredPixels ignored;
  bool find_objects = true;  // whether captions and rulers are found and ignored
  int color_classes = 1;     // 0: automatic
  std::optional<View> view;  // what the photograph shows; none: judged by the picture (measure/view.h)
  bool delight = false;      // whether colors are measured without the photograph's light (delight.h)
  std::uint64_t seed = 1;
  std::uint64_t memory = std::numeric_limits<std::uint64_t>::max();  // bytes that may be used
};

// By Method::Auto: the average precision to expect of each method's particles by their confidences, 0 to 1.
struct Reliability {
  double clusters = 0, network = 0, both = 0;
};

struct Segmentation {
  Labels labels;
  Profiles profiles;
  IgnoredPixels ignored;      // of the options and of the objects that were found
  UndecidedPixels undecided;  // without a label, and not ignored
  Image delit;    // the photograph without its light; empty if colors were measured in the photograph
  Ground ground;  // empty if labels were given
  Method method = Method::Clusters;  // the method used
  double network_scale = 0;          // 0: without the network
  double min_area = 0;               // pixels, of the last section
  std::int64_t specks = 0, speck_pixels = 0, holes = 0;
  bool distinct_phases = false;  // colors differ much more between phases than within them
  Reliability reliability;
  std::int64_t unlikely = 0;              // particles dropped for their confidence
  std::vector<FoundObject> not_material;  // found and ignored
  ViewEvidence evidence;                  // of the view
  TiltEstimate tilt;                      // of the camera, in View::Surface
};

// Pictures of more than 4096² pixels are segmented in tiles (tiles.h). Throws Error "empty-image",
// "bad-pixels", "one-color", "no-particles", "too-large".
Segmentation segment(const Image&, const SegmentOptions&, const Work&);
// Measures existing labels. Throws Error "size-mismatch" if they do not match the image, "empty-image",
// "bad-pixels", "bad-labels", "no-particles".
Segmentation measure_labels(const Image&, const Labels&, const SegmentOptions&, const Work&);

}  // namespace terrazzo::segment
