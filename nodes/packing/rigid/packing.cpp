#include "nodes/packing/rigid/packing.h"

#include <new>

#include "nodes/packing/rigid/packer.h"

namespace terrazzo::packing {

void set_request(PackResult& result, const Population& population) {
  result.size_class = population.size_class;
  result.expected = population.expected;
  result.requested_fraction = population.requested_fraction;
  result.left_out_fraction = population.left_out_fraction;
  result.kept = population.kept;
  result.notes = population.notes;
}

PackResult pack_particles(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                          const PackOptions& options, const Work& work) {
  Packer packer(distribution, shapes, start, options, work);
  try {
    return packer.run();
  } catch (const Cancelled&) {
    try {
      if (options.interrupted)
        if (const auto reached = packer.reached()) options.interrupted(*reached);
    } catch (const std::bad_alloc&) {  // without memory for a copy, the packing is canceled all the same
    }
    throw;
  }
}

}  // namespace terrazzo::packing
