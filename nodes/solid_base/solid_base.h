// SolidBase: what the parts of a large solid share, however it is cut (blocks.h).
#pragma once

#include <vector>

#include "nodes/solid_optimize/blocks.h"
#include "nodes/solid_optimize/from_context.h"
#include "runtime/value.h"

namespace terrazzo {

struct SolidBase {
  solid_optimize::SolidRequest request;  // of the whole; its settings are local, and cut into no blocks
  solid_optimize::LocalBase base;
};

template <>
const ValueType& value_type<SolidBase>();

}  // namespace terrazzo
