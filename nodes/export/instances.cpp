#include "nodes/export/instances.h"

#include <cmath>
#include <string>

#include "graph/diagnostic.h"

namespace terrazzo::exporting {

std::vector<std::vector<std::size_t>> instances_of(const Particles& particles, const Shapes& shapes) {
  if (particles.count() == 0) throw Error("no-particles", "there are no particles to write");
  if (particles.void_count() == particles.count())
    throw Error("no-particles", "all particles are voids: there is nothing to write",
                "export the grid void of Voxelize instead");
  std::vector<std::vector<std::size_t>> members(shapes.shapes.size());
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const std::string who = "particle " + std::to_string(i);
    const auto s = particles.shape[i];
    if (s < 0 || static_cast<std::size_t>(s) >= shapes.shapes.size())
      throw Error("no-such-shape",
                  who + " has shape " + std::to_string(s) + ", but there are only " +
                      std::to_string(shapes.shapes.size()) + " shapes",
                  "connect the shapes used in the packing");
    if (!particles.position[i].allFinite() || !std::isfinite(particles.scale[i]) ||
        !particles.orientation[i].coeffs().allFinite() || !particles.color[i].allFinite() ||
        particles.orientation[i].norm() < 1e-9)
      throw Error("bad-number", who + " has an invalid position, orientation, scale or color");
    if (!particles.is_void(i)) members[s].push_back(i);
  }
  return members;
}

}  // namespace terrazzo::exporting
