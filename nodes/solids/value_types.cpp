#include "nodes/solids/solid_base.h"

namespace terrazzo {

void solids_value_types(ValueTypes& types) { types.add(value_type<SolidBase>()); }

}  // namespace terrazzo
