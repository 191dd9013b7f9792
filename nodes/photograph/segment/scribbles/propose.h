// Proposes the particles that a user's strokes teach.
#pragma once

#include "nodes/photograph/segment/proposal.h"
#include "nodes/photograph/segment/segment.h"

namespace terrazzo::segment {

// Adds what strokes mark as not material to `ignored`. Throws Error "no-strokes".
Proposal propose_by_scribbles(const Image&, const SegmentOptions&, IgnoredPixels& ignored, const Work&);

}  // namespace terrazzo::segment
