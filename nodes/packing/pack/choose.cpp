#include "nodes/packing/pack/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/outline_features.h"
#include "nodes/packing/deposit/deposit.h"
#include "nodes/packing/pack/fabric.h"

namespace terrazzo::pack {
namespace {

constexpr double kNoBinder = 0.97;  // volume fraction
constexpr double kDense = 0.75;     // volume fraction from which packing is not tried
constexpr double kClose = 0.01;     // volume fraction; grown particles come no closer to what is requested
// Largest number of steps, the same times particles, and the fewest steps.
constexpr double kIterations = 1500, kBodySteps = kIterations * 2500, kFewest = 60;
constexpr double kEquiaxed = 0.6;  // least axis ratio
constexpr std::size_t kFew = 5;    // profiles

// Edges of a bed as wide as the photograph, so that a view of it does not repeat, and a few stones deep. It
// holds about the requested number of stones at least, and a few times as many at most; empty if densities
// are relative or the photograph's size is unknown.
std::vector<double> bed_edges(const Profiles& profiles, const SizeDistribution& distribution, double count) {
  constexpr double kDeep = 3, kMostStones = 4;  // largest stones, times the requested number
  double density = 0;
  for (const auto& e : distribution.shapes)
    for (const double n : e.N_V) density += n;
  if (!(distribution.volume_fraction > 0 && density > 0 && profiles.window.minCoeff() > 0)) return {};
  const double least = kDeep * distribution.d_max;
  Vec2 wide = profiles.window;
  const double stones = density * wide.prod() * least;
  if (stones > kMostStones * count) wide *= std::sqrt(kMostStones * count / stones);
  if (wide.minCoeff() < least) return {};  // populate() leaves out the smallest stones then
  const double deep = std::max(least, std::min(count / (density * wide.prod()), wide.minCoeff()));
  // Sixty-fourths of the longest edge, so that whole voxels fill the box at usual resolutions.
  const double unit = wide.maxCoeff() / 64;
  std::vector<double> edges;
  for (const double edge : {wide.x(), wide.y(), deep}) edges.push_back(unit * std::ceil(edge / unit - 1e-9));
  return edges;
}

// Stones of a surface are not grown into each other: in soil, if they jam, they are smaller than requested.
Choice lie_loosely(const SizeDistribution& distribution, const Shapes& shapes, const Profiles& profiles,
                   const Particles* start, const packing::PackOptions& given, const Work& work) {
  packing::PackOptions options = given;
  options.population = bed_like(distribution, profiles, given.population);
  Choice choice;
  if (shows_loose_stones(profiles)) {
    choice.method = Method::Deposit;
    choice.packed = packing::deposit_particles(distribution, shapes, options.population, work);
    choice.reason = "the photograph shows loose stones: they fell until they rested on each other";
    return choice;
  }
  options.on_jam = packing::OnJam::Shrink;
  options.lying = true;
  options.long_axes = long_axes(profiles);
  choice.method = Method::Anneal;
  choice.packed = packing::pack_particles(distribution, shapes, start, options, work);
  choice.reason =
      "the photograph shows stones in soil: they lie flat side down and are not grown into each other";
  return choice;
}

}  // namespace

packing::PopulationOptions bed_like(const SizeDistribution& distribution, const Profiles& profiles,
                                    packing::PopulationOptions options) {
  if (options.edges.empty()) options.edges = bed_edges(profiles, distribution, options.count);
  return options;
}

double usual_axis_ratio(const Profiles& profiles) {
  std::vector<double> ratios;
  for (const Profile& p : profiles.profiles)
    if (!p.touches_border && p.contour.size() >= 3)
      ratios.push_back(outline_features(p.contour)[OutlineFeature::Aspect]);
  return ratios.size() < kFew ? 0 : median(std::move(ratios));
}

double fraction_error(const Profiles& profiles) {
  double area = 0, squares = 0;
  for (const Profile& p : profiles.profiles) {
    area += p.area;
    squares += p.area * p.area;
  }
  return area > 0 ? profiles.area_fraction * (1 - profiles.area_fraction) * std::sqrt(squares) / area : 0;
}

Choice choose_method(const SizeDistribution& distribution, const Shapes& shapes, const Profiles* profiles,
                     const Particles* start, const packing::PackOptions& options, const Work& work) {
  if (profiles != nullptr && profiles->view == View::Surface)
    return lie_loosely(distribution, shapes, *profiles, start, options, work);
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
      pack.on_jam = packing::OnJam::Shrink;
      pack.least = fraction - std::max(kClose, profiles ? fraction_error(*profiles) : 0);
      choice.packed = packing::pack_particles(distribution, shapes, start, pack, work);
      choice.method = Method::Anneal;
      choice.reason = fmt::format("rigid particles reach the volume fraction of {:.3f}, or nearly", fraction);
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
