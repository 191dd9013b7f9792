#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/labels.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/strokes.h"
#include "nodes/data/table.h"
#include "runtime/value.h"

namespace terrazzo {

void data_value_types(ValueTypes& types) {
  types.add(value_type<Image>());
  types.add(value_type<Labels>());
  types.add(value_type<Profiles>());
  types.add(value_type<Shapes>());
  types.add(value_type<KMatrix>());
  types.add(value_type<SizeDistribution>());
  types.add(value_type<Particles>());
  types.add(value_type<Volume>());
  types.add(value_type<Strokes>());
  types.add(value_type<Table>());
  types.add(value_type<Detail>());
}

}  // namespace terrazzo
