#include <optional>

#include "graph/node_type.h"
#include "nodes/common/stereology/profile_columns.h"
#include "nodes/sizes/grain_size/figure.h"
#include "runtime/context.h"

namespace terrazzo::grain_size {
namespace {

void compute(Context& c) {
  const auto& profiles = c.input<Profiles>("profiles");
  const Image* image = c.optional<Image>("image");
  const auto* distribution = c.optional<SizeDistribution>("distribution");
  const auto scale = c.choice<Scale>("scale");
  const std::vector<ProfileColumn> columns = profile_columns(profiles, c.work());
  const Sizes sizes = sizes_of(profiles, columns, c.choice<Diameter>("diameter"));
  std::optional<CrystalSizes> crystals;
  if (distribution) {
    crystals = crystal_sizes(*distribution);
    crystals->relative = profiles.observed_area == 0;
  }
  const auto measures = measures_of(sizes, static_cast<int>(c.integer("repetitions")), c.seed(), c.work());
  const CrystalSizes* found = crystals ? &*crystals : nullptr;
  c.metric("profiles", sizes.diameter.size());
  for (const Measure& m : measures)
    if (m.name == "D50 by number") c.metric("D50_by_number", m.value);
  c.output("table", table_of(measures, found, scale));
  c.output("grains", grains_of(profiles, columns,
                               image ? mean_colors(profiles, *image, c.work()) : std::vector<Vec3f>(),
                               image ? image->pixel_size : 0));
  c.output("figure", figure_of(sizes, found, scale));
}

}  // namespace
}  // namespace terrazzo::grain_size

namespace terrazzo {

NodeType grain_size_node() {
  using namespace grain_size;
  return NodeType("GrainSize", 2)
      .doc_(
          "Reports the sizes of profiles as sedimentologists and metallographers do: percentiles by number, "
          "area and weight, mean intercepts and ASTM grain size numbers, with 90 % intervals. Sizes are "
          "those "
          "of profiles, not of particles in space, which Unfold estimates.")
      .source_("Kellerhals and Bray 1971 (weights); ASTM E112-13, table 6; Marsh 1988 (crystal sizes)")
      .input("profiles", "Profiles", "Profiles to measure. Those of weight 0, at the border, do not count")
      .optional_input("image", {"Image"}, "Picture of the profiles, for mean colors and lengths in pixels")
      .optional_input("distribution", {"SizeDistribution"},
                      "Sizes in space, for the slope of the crystal size distribution")
      .output("table", "Table", "measure, value, low and high end of its 90 % interval, unit")
      .output("grains", "Table", "One row per profile, with the measures that Export writes")
      .output("figure", "Image",
              "Cumulative curves by number, area and weight; with distribution, also crystal sizes")
      .parameter(
          Parameter::choice("diameter", "equivalent_diameter",
                            {"equivalent_diameter", "major_axis", "minor_axis", "feret_max", "feret_min"})
              .doc_("Diameter whose percentiles are reported. equivalent_diameter: of the circle of "
                    "the same area. The axes are those of the ellipse with the same second moments; "
                    "feret_max and feret_min are the largest and smallest caliper. All but the first "
                    "need outlines."))
      .parameter(Parameter::choice("scale", "mm", {"mm", "phi"})
                     .doc_("Scale of the sizes and the figure. phi: −log₂ of the diameter in mm. D16 "
                           "stays the diameter that 16 % are finer than."))
      .parameter(Parameter::integer("repetitions", 1000)
                     .range(1, 100000)
                     .doc_("Repetitions of the bootstrap over profiles, or over sections from 10 on"))
      .parameter(Parameter::seed().doc_("Random seed of the bootstrap"))
      .compute_(compute);
}

}  // namespace terrazzo
