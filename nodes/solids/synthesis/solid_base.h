// SolidBase: the data that all blocks of a large solid share, however it is cut (blocks.h).
#pragma once

#include <vector>

#include "nodes/solids/synthesis/blockwise/blocks.h"
#include "nodes/solids/synthesis/request.h"
#include "runtime/value.h"

namespace terrazzo {

struct SolidBase {
  solids::SolidRequest request;  // for the whole solid; the settings have method blockwise and one block
  solids::BlockBase base;
};

template <>
const ValueType& value_type<SolidBase>();

}  // namespace terrazzo
