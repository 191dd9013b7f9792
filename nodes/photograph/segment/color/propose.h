// Proposes the bodies that color separates from the binder.
#pragma once

#include <vector>

#include "nodes/photograph/segment/network/sections.h"
#include "nodes/photograph/segment/proposal.h"
#include "nodes/photograph/segment/segment.h"

namespace terrazzo::segment {

// What color separates in one section, and what the network says of it.
struct Bodies {
  Particles2D particles;
  std::vector<bool> faint;     // of label k at k − 1
  std::vector<double> scores;  // likewise
};

struct ColorProposal {
  Proposal proposal;
  std::vector<Bodies> bodies;    // of each section; only with a network
  std::vector<bool> distinct;    // of each section: whether the colors of its phases differ clearly
  bool distinct_phases = false;  // of the stack
  Ground ground;
};

// `known`: clusters and binder, if they are settled. `judge`: gives the bodies their confidences; without
// one, all are 1. Throws Error "one-color".
ColorProposal propose_by_color(const Image&, const SegmentOptions&, const Ground* known,
                               NetworkSections* judge, const Work&);

}  // namespace terrazzo::segment
