// MediaBase: what all blocks of a large solid of phases share, however it is cut.
#pragma once

#include "nodes/media/annealing/request.h"
#include "runtime/value.h"

namespace terrazzo {

struct MediaBase {
  annealing::PhaseRequest request;  // for the whole solid
  annealing::CoarseSolid coarse;
};

template <>
const ValueType& value_type<MediaBase>();

}  // namespace terrazzo
