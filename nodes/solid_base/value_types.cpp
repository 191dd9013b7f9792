#include "nodes/solid_base/solid_base.h"

namespace terrazzo {

void solid_base_value_types(ValueTypes& types) { types.add(value_type<SolidBase>()); }

}  // namespace terrazzo
