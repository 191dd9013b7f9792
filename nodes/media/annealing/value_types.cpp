#include "nodes/media/annealing/media_base.h"

namespace terrazzo {

void annealing_value_types(ValueTypes& types) { types.add(value_type<MediaBase>()); }

}  // namespace terrazzo
