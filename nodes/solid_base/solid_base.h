// SolidBase: the data that all blocks of a large solid share, however it is cut (blocks.h).
#pragma once

#include <vector>

#include "nodes/solid_optimize/blocks.h"
#include "nodes/solid_optimize/from_context.h"
#include "runtime/value.h"

namespace terrazzo {

struct SolidBase {
  solid_optimize::SolidRequest request;  // for the whole solid; the settings have method local and one block
  solid_optimize::LocalBase base;
};

template <>
const ValueType& value_type<SolidBase>();

}  // namespace terrazzo
