#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/kmatrix/make_kmatrix.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  KMatrixOptions options;
  options.method = c.text("method");
  options.classes = static_cast<int>(c.integer("classes"));
  options.averaging = c.text("averaging");
  const bool automatic = c.keyword("orientations") == "auto";
  if (!automatic) options.orientations = static_cast<std::size_t>(c.integer("orientations"));
  std::size_t used = 0;
  KMatrix k = make_kmatrix(c.input<Shapes>("shapes"), options, c.work(), &used);
  if (automatic && k.residual > 1e-3)
    c.warn(fmt::format(
        "after {} directions a class still changed by {:.2g} %; use fewer classes or set orientations", used,
        100 * k.residual));
  double caliper = 0, profiles = 0;
  for (const auto& e : k.shapes)
    caliper += e.probability * e.mean_caliper, profiles += e.probability * e.profiles_per_caliper;
  c.metric("mean_caliper", caliper);
  c.metric("profiles_per_caliper", profiles);
  c.metric("residual", k.residual);
  if (options.method == "slice") c.metric("orientations", static_cast<double>(used));
  c.output("kmatrix", std::move(k));
}

}  // namespace

NodeType kmatrix_node() {
  return NodeType("KMatrix", 1)
      .doc_(
          "How often a particle of each size shows a profile of each size in a random plane, for every "
          "shape: the "
          "matrix that Unfold inverts. Classes are equal bins of √(A/A_max), A_max being the largest section "
          "over "
          "all planes.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 3, eq. 3, 5, 6, 10")
      .input("shapes", "Shapes", "The particles' forms with their probabilities")
      .output("kmatrix", "KMatrix",
              "One matrix per shape, with mean caliper, largest section and profiles per caliper")
      .parameter(
          Parameter::choice("method", "slice", {"slice", "analytic"})
              .doc_("slice cuts any closed mesh: quasi-random directions, all depths of each integrated "
                    "exactly, "
                    "disjoint profiles counted apart. analytic is the closed form for spheres, spheroids and "
                    "ellipsoids, and refuses a mesh that is not the tessellation of one (vertices within 0.1 "
                    "%, "
                    "90 % of its volume filled)."))
      .parameter(
          Parameter::integer("classes", 10).range(1, 200).doc_("Number of equal classes of √(A/A_max)"))
      .parameter(
          Parameter::choice("averaging", "uniform", {"uniform", "upper_edge"})
              .doc_("Sizes within a column's class: uniform, or all at its upper edge as in the paper's "
                    "equation 3, which biases what is unfolded with it."))
      .parameter(Parameter::with_keyword(ParameterKind::Int, "orientations", "auto")
                     .range(2, 10000000)
                     .doc_("Directions that slice uses; auto doubles them until no class changes by more "
                           "than 0.1 %, at "
                           "most 65536."))
      .compute_(compute);
}

}  // namespace terrazzo
