#include "graph/node_type.h"
#include "nodes/sizes/resample_profiles/resample_profiles.h"
#include "runtime/context.h"

namespace terrazzo::resample_profiles {
namespace {

void compute(Context& c) {
  Profiles out = resample(c.input<Profiles>("profiles"), static_cast<int>(c.integer("draw")), c.seed());
  if (out.profiles.empty())
    throw Error("no-profiles", "no profile was drawn, because there are so few",
                "use a larger photograph, or another draw")
        .parameter("draw");
  c.metric("profiles", out.profiles.size());
  c.metric("area_fraction", out.area_fraction);
  c.output("profiles", std::move(out));
}

}  // namespace
}  // namespace terrazzo::resample_profiles

namespace terrazzo {

NodeType resample_profiles_node() {
  using namespace resample_profiles;
  return NodeType("ResampleProfiles", 1)
      .doc_(
          "Draws the profiles of another photograph of the same material, with replacement (bootstrap), to "
          "see how much "
          "a result depends on the photograph.")
      .source_("Efron 1979; Rao and Wu 1988")
      .input("profiles", "Profiles", "Profiles of the photograph")
      .output("profiles", "Profiles",
              "The profiles drawn. Each appears any number of times; the binder between them keeps its area, "
              "so that the "
              "observed area and the area fraction follow.")
      .parameter(Parameter::integer("draw", 1)
                     .range(0, 1000000)
                     .doc_("Number of the draw. 0: the photograph itself."))
      .parameter(Parameter::seed().doc_("Random seed of all draws"))
      .compute_(compute);
}

}  // namespace terrazzo
