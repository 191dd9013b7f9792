#include "graph/node_type.h"
#include "nodes/color/colorize/colorize.h"
#include "nodes/common/texture/color.h"
#include "runtime/context.h"

namespace terrazzo::colorize {
namespace {

// Distance in Oklab between the particles' mean color and the weighted mean of the profiles.
double mean_difference(const Particles& particles, const Profiles& profiles) {
  Vec3 seen = Vec3::Zero(), given = Vec3::Zero();
  double weights = 0;
  for (const auto& p : profiles.profiles) {
    seen += p.weight * p.color.cast<double>();
    weights += p.weight;
  }
  const std::size_t shown = particles.count() - particles.void_count();
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) given += particles.color[i].cast<double>();
  if (weights <= 0 || shown == 0) return 0;
  const auto lab = [](const Vec3& v) { return linear_to_oklab(v.cast<float>()); };
  return (lab(seen / weights) - lab(given / static_cast<double>(shown))).norm();
}

void compute(Context& c) {
  Particles particles = c.input<Particles>("particles");
  const Profiles& profiles = c.input<Profiles>("profiles");
  ColorOptions choice;
  choice.mode = c.choice<ColorMode>("mode");
  choice.seed = c.seed();
  choice.clusters = c.optional_integer("clusters").value_or(0);
  const ColorReport report = colorize::colorize(particles, profiles, choice, c.work());
  if (report.weightless) c.warn("every profile touches the border, so all have equal weight");
  if (report.colorless) c.warn("all profiles are black: they have no color data");
  c.metric("profiles_used", report.profiles_used);
  c.metric("mean_color_difference", mean_difference(particles, profiles));
  if (report.hidden > 0) c.metric("hidden", report.hidden);
  if (report.clusters > 0) {
    c.metric("clusters", report.clusters);
    c.metric("silhouette", report.silhouette);
  }
  c.output("particles", std::move(particles));
}

}  // namespace
}  // namespace terrazzo::colorize

namespace terrazzo {

NodeType colorize_node() {
  using namespace colorize;
  return NodeType("Colorize", 7)
      .doc_(
          "Gives every particle the color of a profile of the photograph (its median), and the binder its "
          "mean "
          "color. Voids stay black.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 4.2")
      .input("particles", "Particles", "Particles to color")
      .input("profiles", "Profiles", "Profiles with colors and weights, and the binder's color")
      .output("particles", "Particles",
              "The same particles with colors. Mode classes may also set their classes.")
      .parameter(
          Parameter::choice("mode", "random", {"random", "by_size", "classes"})
              .doc_(
                  "random: any profile, unbiased if color does not depend on size. by_size: profiles that a "
                  "section of a particle of this size may show, of the particle's class if there are "
                  "several. classes: profiles of the particle's class; "
                  "particles without classes get the profiles' classes by size, or classes from k-means."))
      .parameter(Parameter::optional_integer("clusters", "auto")
                     .range(1, 64)
                     .doc_("Number of color classes that k-means finds if neither particles nor profiles "
                           "have classes. auto: 1 to 8, by silhouette."))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
