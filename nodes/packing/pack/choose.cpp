#include "nodes/packing/pack/choose.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/outline_features.h"

namespace terrazzo::pack {
namespace {

constexpr double kNoBinder = 0.97;  // volume fraction
constexpr double kDense = 0.75;     // volume fraction from which packing is not tried
// Largest number of steps, the same times particles, and the fewest steps.
constexpr double kIterations = 1500, kBodySteps = kIterations * 2500, kFewest = 60;
constexpr double kEquiaxed = 0.6;  // least axis ratio
constexpr std::size_t kFew = 5;    // profiles

}  // namespace

double usual_axis_ratio(const Profiles& profiles) {
  std::vector<double> ratios;
  for (const Profile& p : profiles.profiles)
    if (!p.touches_border && p.contour.size() >= 3)
      ratios.push_back(outline_features(p.contour)[OutlineFeature::Aspect]);
  return ratios.size() < kFew ? 0 : median(std::move(ratios));
}

Choice choose_method(const SizeDistribution& distribution, const Shapes& shapes, const Profiles* profiles,
                     const Particles* start, const packing::PackOptions& options, const Work& work) {
  packing::PopulationOptions any = options.population;
  any.fills_space = true;
  const packing::Population population = packing::populate(distribution, shapes, nullptr, any, work.quiet());
  const double fraction = population.target_fraction;
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
      pack.iterations = static_cast<int>(
          std::clamp(kBodySteps / static_cast<double>(population.particles.count()), kFewest, kIterations));
      pack.hopeless = 0;  // if a sample jams, all do, or after long
      choice.packed = packing::pack_particles(distribution, shapes, start, pack, work);
      choice.method = Method::Anneal;
      choice.reason = fmt::format("rigid particles reach the volume fraction of {:.3f}", fraction);
      return choice;
    } catch (const Error& e) {
      if (e.diagnostic().code != "jammed" && e.diagnostic().code != "overlap") throw;
    }
  if (fraction >= kDense && profiles != nullptr && usual_axis_ratio(*profiles) >= kEquiaxed) {
    choice.method = Method::Laguerre;
    choice.joints = true;
    choice.reason = fmt::format(
        "a volume fraction of {:.3f} leaves joints between neighbors only: the particles are cells of a "
        "Laguerre tessellation with joints and round edges",
        fraction);
    return choice;
  }
  choice.method = Method::Grow;
  choice.reason = fmt::format(
      "rigid particles do not reach the volume fraction of {:.3f}: they are packed less "
      "densely and then enlarged into each other",
      fraction);
  return choice;
}

}  // namespace terrazzo::pack
