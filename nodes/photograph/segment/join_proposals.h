// Joins what color and the network propose.
#pragma once

#include "nodes/photograph/segment/color/propose.h"
#include "nodes/photograph/segment/network/sections.h"
#include "nodes/photograph/segment/proposal.h"

namespace terrazzo::segment {

// In each section whose phases have distinct colors, bodies of color and candidates of the network are
// rivals, and the better score wins where they overlap. In the other sections, bodies of color would only
// stand in the network's way, so it chooses alone.
Proposal join_proposals(const Image&, const ColorProposal&, NetworkSections&, const NetworkOptions& choice,
                        const SplitOptions&, const Work&);

}  // namespace terrazzo::segment
