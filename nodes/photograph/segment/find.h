// The particles of a picture by the chosen method, before they are measured.
#pragma once

#include <vector>

#include "nodes/photograph/segment/segment.h"

namespace terrazzo::segment {

struct Finding {
  Segmentation result;             // all but the profiles
  std::vector<float> coverage;     // of each pixel of the stack
  std::vector<double> confidence;  // of label k at k − 1
  UndecidedPixels undecided;       // of Method::Network
  IgnoredPixels ignored;           // those of the options and of the objects that the network found
};

// What is settled already when a part of a larger picture is segmented.
struct Settled {
  Method method = Method::Network;  // of Method::Auto
  const Ground* ground = nullptr;   // clusters and binder; none: find them
};

// All sections at once. Throws Error "one-color".
Finding find_in_whole(const Image&, const SegmentOptions&, const Settled*, const Work&);

}  // namespace terrazzo::segment
