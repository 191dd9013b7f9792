#include "nodes/packing/rigid/save_interrupted.h"

#include <fmt/format.h>

#include "nodes/common/io/particles_json.h"
#include "nodes/packing/rigid/statistics.h"

namespace terrazzo::packing {

std::function<void(const InterruptedPacking&)> saving(Context& c, const Shapes& shapes) {
  return [&c, &shapes](const InterruptedPacking& reached) {
    const Particles& p = reached.particles;
    std::string what = fmt::format("the packing so far ({} particle{}, volume fraction {:.3f}", p.count(),
                                   p.count() == 1 ? "" : "s", volume_fraction(shapes, p));
    if (reached.overlap > kTolerance)
      what += fmt::format(", overlaps of up to {:.2f} % of a particle's size", 100 * reached.overlap);
    what += ")";
    c.save_interrupted(".json", what, "to continue, load it with LoadParticles and connect it to `start`",
                       [&p](const std::filesystem::path& file) { write_particles_json(file, p); });
  };
}

}  // namespace terrazzo::packing
