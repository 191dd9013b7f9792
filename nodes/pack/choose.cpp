#include "nodes/pack/choose.h"

#include <fmt/format.h>

#include "graph/diagnostic.h"

namespace terrazzo::pack {
namespace {

constexpr double kNoBinder = 0.97;  // volume fraction
constexpr double kDense = 0.75;     // volume fraction from which packing is not tried
constexpr double kNear = 0.02;      // how far above the estimate it is tried
constexpr int kIterations = 1500;

}  // namespace

Choice choose_method(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                     const packing::PackOptions& options, const Work& work) {
  packing::PopulationOptions any = options.population;
  any.fills_space = true;
  const double fraction =
      packing::populate(distribution, shapes, nullptr, any, work.quiet()).requested_fraction;
  Choice choice;
  if (fraction >= kNoBinder) {
    choice.method = Method::Laguerre;
    choice.reason = fmt::format(
        "a volume fraction of {:.3f} leaves no binder: the particles are the cells of a "
        "Laguerre tessellation",
        fraction);
    return choice;
  }
  if (fraction < kDense) try {
      packing::PackOptions pack = options;
      pack.iterations = kIterations;
      pack.hopeless = kNear;
      choice.packed = packing::pack_particles(distribution, shapes, start, pack, work);
      choice.method = Method::Anneal;
      choice.reason = fmt::format("rigid particles reach the volume fraction of {:.3f}", fraction);
      return choice;
    } catch (const Error& e) {
      if (e.diagnostic().code != "jammed" && e.diagnostic().code != "overlap") throw;
    }
  choice.method = Method::Grow;
  choice.reason = fmt::format(
      "rigid particles do not reach the volume fraction of {:.3f}: they are packed less "
      "densely and then enlarged into each other",
      fraction);
  return choice;
}

}  // namespace terrazzo::pack
