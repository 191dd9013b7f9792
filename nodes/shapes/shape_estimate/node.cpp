#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "graph/node_type.h"
#include "nodes/data/profiles.h"
#include "nodes/shapes/shape_estimate/estimate_class.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/relief.h"
#include "runtime/context.h"

namespace terrazzo::shape_estimate {
namespace {

CandidateOptions candidate_options(const Context& c) {
  CandidateOptions options;
  if (const auto v = c.optional_integer("class")) options.cls = *v;
  options.smallest = c.number("smallest");
  options.crease = c.number("crease");
  return options;
}

// Whether the class that covers most is of round stones.
bool shows_balls(const std::vector<std::vector<Outline>>& of_class) {
  double most = 0;
  bool round = false;
  for (const std::vector<Outline>& outlines : of_class) {
    double area = 0;
    for (const Outline& o : outlines) area += o.area;
    if (area <= most) continue;
    most = area;
    round = usual_relief(outlines) < kRound;
  }
  return round;
}

// Shapes of every class with enough profiles. The others get the shapes of all profiles together.
std::vector<ClassEstimate> estimate_classes(Context& c, const Profiles& profiles) {
  CandidateOptions options = candidate_options(c);
  std::vector<std::size_t> of_class(profiles.classes, 0);
  for (const Profile& p : profiles.profiles) {
    if (p.cls < 0 || p.cls >= profiles.classes)
      throw Error("bad-profile", fmt::format("a profile has the class {}, but there are only {} classes",
                                             p.cls, profiles.classes))
          .parameter("class");
    ++of_class[p.cls];
  }
  std::vector<std::vector<Outline>> usable;
  for (options.cls = 0; options.cls < profiles.classes; ++options.cls)
    usable.push_back(of_class[options.cls] == 0 ? std::vector<Outline>()
                                                : candidates_of(profiles, options, c.work()).outlines);
  // In a picture of balls, a class of other outlines is of parts: of balls that lie deep, in the shadow.
  const bool balls = profiles.view == View::Surface && shows_balls(usable);
  std::vector<int> own, shared;
  for (int cls = 0; cls < profiles.classes; ++cls) {
    if (of_class[cls] == 0) continue;
    const bool parts = balls && usual_relief(usable[cls]) >= kRound;
    (usable[cls].size() >= kFitLeast && !parts ? own : shared).push_back(cls);
  }
  std::vector<ClassEstimate> out;
  const double parts = static_cast<double>(own.size()) + (shared.empty() ? 0 : 1);
  const auto add = [&](const std::vector<int>& classes) {
    const double at = out.size();
    const Work part = c.work().part(std::min(1.0, at / parts), std::min(1.0, (at + 1) / parts));
    ClassEstimate made = estimate_class(c, profiles, options, part);
    for (const int cls : classes) {
      ClassEstimate& e = out.emplace_back(made);
      for (Shape& s : e.shapes) {
        s.cls = cls;
        s.name = fmt::format("class {}: {}", cls, s.name);
        s.probability *= static_cast<double>(of_class[cls]) / profiles.profiles.size();
      }
    }
  };
  for (const int cls : own) {
    options.cls = cls;
    add({cls});
  }
  options.cls = -1;
  if (!shared.empty()) add(shared);
  c.metric("classes_with_shapes_of_all", shared.size());
  return out;
}

void compute(Context& c) {
  const auto& profiles = c.input<Profiles>("profiles");
  std::vector<ClassEstimate> classes;
  if (c.keyword("class") == "each" && profiles.classes > 1 && !c.keyword("profiles").empty())
    classes = estimate_classes(c, profiles);
  else
    classes.push_back(estimate_class(c, profiles, candidate_options(c), c.work()));
  Shapes shapes;
  ClassEstimate all;
  for (ClassEstimate& e : classes) {
    std::move(e.shapes.begin(), e.shapes.end(), std::back_inserter(shapes.shapes));
    all.usable += e.usable;
    all.triangles += e.triangles;
    all.self_intersections += e.self_intersections;
    all.deviation = std::max(all.deviation, e.deviation);
    all.lobed = std::max(all.lobed, e.lobed);
    all.start_distance = std::max(all.start_distance, e.start_distance);
    all.distance = std::max(all.distance, e.distance);
  }
  c.metric("usable_profiles", all.usable);
  c.metric("shapes", shapes.shapes.size());
  c.metric("triangles", all.triangles);
  c.metric("self_intersections", all.self_intersections);
  c.metric("lobed", all.lobed);
  if (all.deviation >= 0) c.metric("deviation", all.deviation);
  if (all.distance >= 0) {
    c.metric("start_distance", all.start_distance);
    c.metric("distance", all.distance);
  }
  c.output("shapes", std::move(shapes));
}

Parameter method_parameter() {
  std::vector<std::string> names;
  std::string doc = "Method that turns profiles into shapes.";
  for (const auto& m : estimate_methods()) {
    names.push_back(m.name);
    doc += fmt::format(" {} ({}{} profile{}): {}.", m.name, m.least,
                       m.most == m.least ? ""
                       : m.most          ? fmt::format(" to {}", m.most)
                                         : " or more",
                       m.least == 1 && m.most == 1 ? "" : "s", m.doc);
  }
  names.push_back("auto");
  doc += fmt::format(
      " auto: for a surface faceted if outlines turn at corners, otherwise inflation; fit with at least {} "
      "usable profiles of sections, otherwise "
      "morphed_generalized_cylinder. If large particles are lobed and small ones are not, these are the "
      "methods for the small ones, and the large ones get `count` bodies of lobes; shares depend on the "
      "size.",
      kFitEnough);
  return Parameter::choice("method", "morphed_generalized_cylinder", names).doc_(doc);
}

}  // namespace
}  // namespace terrazzo::shape_estimate

namespace terrazzo {

NodeType shape_estimate_node() {
  using namespace shape_estimate;
  return NodeType("ShapeEstimate", 18)
      .doc_(
          "Estimates plausible particle shapes from the outlines of their plane sections, or from the "
          "silhouettes that a surface shows. How the sections of different particles are arranged in space "
          "is unknown; each method makes a different assumption.")
      .source_(
          "Jagnow, Dorsey, Rushmeier 2008, section 3; Hobolth, Jensen 2002; Dischler, Ghazanfarpour 1999")
      .input("profiles", "Profiles", "Profiles with contours, as from Segment or Section")
      .output("shapes", "Shapes",
              "`count` shapes at the scale of the profiles, equally probable, except with `fit`, which "
              "estimates probabilities")
      .parameter(method_parameter())
      .parameter(
          Parameter::with_keyword(ParameterKind::Ints, "profiles", "representative")
              .keyword("largest")
              .keyword("diverse")
              .range(1, 1e9)
              .doc_("Profiles to use. representative: the most common kinds. largest: the largest. diverse: "
                    "the most different. Otherwise ids as in Labels (1 is the first): `profiles_per_shape` "
                    "ids per shape; with fewer, every shape uses all of them, each with a different base."))
      .parameter(Parameter::optional_integer("count", "auto")
                     .range(1, 100)
                     .doc_("Number of different shapes. With fit, the maximum: shapes of negligible weight "
                           "are dropped. auto: 3, and up to 40 of a surface except with fit."))
      .parameter(Parameter::integer("profiles_per_shape", 3)
                     .range(1, 12)
                     .doc_("Number of profiles per shape, within the limits of the method"))
      .parameter(Parameter::integer("subdivision", 1)
                     .range(0, 4)
                     .doc_("Number of Catmull–Clark subdivision levels. Each level quadruples the number of "
                           "triangles (about 500 to 2000 at 1, and 2,900 of an inflation and 5,000 of a "
                           "faceted body, which are not "
                           "Catmull–Clark; with tessellation: direct, 4,000 at 1 and 260,000 at 4). With "
                           "control: auto, each level also allows more "
                           "control points; grids with more than ten per quarter are subdivided only once."))
      .parameter(
          Parameter::choice("tessellation", "fitted", {"fitted", "direct"})
              .doc_("Surface of the two cylinders. fitted: a subdivision surface through few points, with "
                    "sharp edges at corners of the profiles. direct: triangles between points of equation 1 "
                    "at equal arc lengths, about 8·2^subdivision per quarter of a curve."))
      .parameter(
          Parameter::optional_integer("control", "auto")
              .range(2, 24)
              .doc_("Number of control points per quarter of a fitted curve. auto: the fewest that reproduce "
                    "the profiles within 0.8 % of their diameter, at most 4 + 2·subdivision, or 24 if "
                    "subdivision is 2 or more."))
      .parameter(
          Parameter::choice("axis", "auto", {"auto", "short", "long", "alternate"})
              .doc_("Orientation of profiles on the base. short: lying, for flat and equant shapes. "
                    "long: upright, for elongated shapes. auto: the one that scales the profiles less, "
                    "which is right for the principal sections of one body; short for a surface. alternate: "
                    "short and long in turn."))
      .parameter(
          Parameter::number("crease", 30)
              .unit_("degrees")
              .range(10, 180)
              .doc_("Smallest turn of the outline that becomes a sharp edge. 180: all edges are smooth."))
      .parameter(
          Parameter::number("smallest", 0.4)
              .range(0, 1)
              .doc_(
                  "Smallest profile to use: √area relative to the √area that a tenth of the profiles exceed"))
      .parameter(
          Parameter::choice("sizes", "unknown", {"unknown", "equal"})
              .doc_("Particle sizes, for method fit. equal: all particles have one size, so the areas of "
                    "their profiles carry information about their shape. unknown: areas are not used."))
      .parameter(
          Parameter::optional_number("thickness", "auto")
              .range(0.05, 2)
              .doc_("Stones of a surface lie flat, so that a photograph shows their two longer axes: their "
                    "height relative to the shorter of these two. auto: the median ratio of the two axes, an "
                    "assumption (metric thickness). Not used for sections."))
      .parameter(Parameter::integer("rounds", 3)
                     .range(1, 60)
                     .doc_("Number of search rounds per shape, for method fit"))
      .parameter(Parameter::optional_integer("class", "any")
                     .keyword("each")
                     .range(0, 1e6)
                     .doc_("Color or particle class whose profiles are used. any: all together. each: every "
                           "class gets `count` shapes of its own; those with fewer than 12 usable profiles "
                           "get the shapes of all profiles."))
      .parameter(Parameter::seed().doc_("Random seed of the choice of profiles and of random shapes"))
      .compute_(compute);
}

}  // namespace terrazzo
