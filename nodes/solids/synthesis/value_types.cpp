#include "nodes/solids/synthesis/solid_base.h"

namespace terrazzo {

void synthesis_value_types(ValueTypes& types) { types.add(value_type<SolidBase>()); }

}  // namespace terrazzo
