#include "nodes/packing/rigid/request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace terrazzo::packing {

NodeType& declare_population(NodeType& type) {
  return type
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "size", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .count(1, 3)
                     .doc_("Edge length of the box: one value for a cube, two for x = y and z, or three for "
                           "x, y and z. auto: a cube for about `count` particles, at least three times the "
                           "largest particle unless that would need ten times as many, or more than 2,500. "
                           "If even a box that the largest particle just fits into would hold more than "
                           "5,000 and `count`, the smallest particles are left to the binder."))
      .parameter(Parameter::integer("count", 2000)
                     .range(1, 1000000)
                     .doc_("Number of particles for which an automatic box is sized"))
      .parameter(Parameter::seed().doc_("Random seed of positions, orientations and sizes"))
      .parameter(Parameter::choice("conserve", "volume_fraction", {"volume_fraction", "number_density"})
                     .doc_("Quantity to keep if the shapes' volumes contradict the distribution's volume "
                           "fraction. volume_fraction: scale all number densities to keep the volume "
                           "fraction. number_density: keep the number densities."));
}

namespace {

constexpr double kOtherCount = 0.1, kOtherFraction = 0.005;  // relative differences that a warning names

}  // namespace

void report_population(Context& c, const Particles& particles, double fraction, double requested_fraction,
                       double left_out_fraction, bool explained) {
  const double made = particles.count();
  c.metric("particles", made);
  c.metric("packing_fraction", fraction);
  c.metric("requested_fraction", requested_fraction);
  c.metric("left_out_fraction", left_out_fraction);
  if (!explained && std::abs(fraction - requested_fraction) > kOtherFraction * requested_fraction)
    c.warn(fmt::format("the particles fill {:.3f} of the box; {:.3f} was requested", fraction,
                       requested_fraction));
  if (c.keyword("size") != "auto") return;
  const double asked = c.integer("count");
  c.metric("requested_count", asked);
  if (std::abs(made - asked) <= std::max(1.0, kOtherCount * asked) || particles.count() == 0) return;
  if (explained && made < asked) return;  // particles were left out
  const double largest = *std::max_element(particles.size.begin(), particles.size.end());
  c.warn(
      fmt::format("there are {} particles; `count` asks for {}. The box of {:.4g} mm is {:.2g} times the "
                  "largest particle; set `size` to choose it",
                  particles.count(), c.integer("count"), particles.box[0], particles.box[0] / largest));
}

PopulationOptions read_population(const Context& c) {
  PopulationOptions o;
  if (c.keyword("size") != "auto") o.edges = c.numbers("size");
  o.count = c.integer("count");
  o.conserve = c.choice<Conserve>("conserve");
  o.seed = c.seed();
  if (const auto* profiles = c.optional<Profiles>("profiles"))
    o.clusters = measure_clusters(*profiles, c.work().quiet());
  return o;
}

}  // namespace terrazzo::packing
