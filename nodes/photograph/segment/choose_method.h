// The rules by which `method: auto` chooses a segmentation.
#pragma once

#include "nodes/photograph/segment/color/propose.h"
#include "nodes/photograph/segment/proposal.h"
#include "nodes/photograph/segment/segment.h"

namespace terrazzo::segment {

// What the options already say: scribbles if there are strokes; the network if there is no binder; clusters
// if the binder or the number of clusters is given. Otherwise Auto: proposals are compared.
Method method_of(const SegmentOptions&);

// The average precision to expect of each proposal: right / (found + missed), if there is at least what the
// best of them gets right.
Reliability reliability_of(const Proposal& clusters, const Proposal& network, const Proposal& both);

// Clusters, Both or Network, by their reliability. The network judges its own particles too, so it has to be
// clearly better than clusters.
Method most_reliable(const Reliability&, const ColorProposal&, const Proposal& network);

}  // namespace terrazzo::segment
