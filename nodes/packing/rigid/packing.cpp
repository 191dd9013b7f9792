#include "nodes/packing/rigid/packing.h"

#include <new>

#include "nodes/packing/rigid/packer.h"

namespace terrazzo::packing {

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
