// Proposes the particles that the network finds.
#pragma once

#include <vector>

#include "nodes/photograph/marks/objects.h"
#include "nodes/photograph/segment/network/sections.h"
#include "nodes/photograph/segment/proposal.h"

namespace terrazzo::segment {

struct NetworkProposalOptions {
  NetworkOptions choice;     // which candidates become particles
  bool find_objects = true;  // whether rulers, frames and text are added to what is ignored
  bool fills_space = false;  // without a binder, nothing is undecided
};

// `photo`: the stack as photographed. Adds objects to `ignored` and `objects`.
Proposal propose_by_network(NetworkSections&, const Image& photo, const NetworkProposalOptions&,
                            IgnoredPixels& ignored, std::vector<FoundObject>& objects, const Work&);

}  // namespace terrazzo::segment
