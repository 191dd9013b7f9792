#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "nodes/common/geometry/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/profiles.h"
#include "nodes/shape_estimate/choose.h"
#include "nodes/shape_estimate/fit.h"
#include "nodes/shape_estimate/method.h"
#include "nodes/shape_estimate/self_intersections.h"
#include "runtime/context.h"

namespace terrazzo {

namespace {

using namespace shape_estimate;  // not in terrazzo itself, because other nodes have an Outline too

const EstimateMethod& method_of(const std::string& name) {
  const auto& all = estimate_methods();
  return *std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == name; });
}

CandidateOptions candidate_options(const Context& c) {
  CandidateOptions options;
  if (const auto v = c.optional_integer("class")) options.cls = static_cast<int>(*v);
  options.smallest = c.number("smallest");
  options.crease = c.number("crease");
  return options;
}

struct Chosen {
  std::vector<std::vector<Outline>> shapes;  // profiles of each shape
  std::vector<Outline> all;
  bool by_id = false;
  bool same = false;  // every shape uses the same profiles
};

constexpr std::size_t kFitHands = 4, kFitLeast = 12, kFitEnough = 24;

// The method that the parameter names; with auto, fit if there are enough profiles.
const EstimateMethod& chosen_method(Context& c, const Profiles& profiles) {
  const std::string name = c.text("method");
  if (name != "auto") return method_of(name);
  if (c.keyword("profiles").empty()) return method_of("morphed_generalized_cylinder");
  const std::size_t usable = candidates_of(profiles, candidate_options(c), c.work()).outlines.size();
  return method_of(usable >= kFitEnough ? "fit" : "morphed_generalized_cylinder");
}

[[noreturn]] void too_few(const Profiles& profiles, const Candidates& candidates, std::size_t each) {
  const bool no_outlines =
      !profiles.profiles.empty() && candidates.without_contour == static_cast<int>(profiles.profiles.size());
  throw Error("too-few-profiles",
              fmt::format("a shape needs {} profiles; of the {} given: {}", each, profiles.profiles.size(),
                          candidates.text()),
              no_outlines
                  ? "these profiles are areas without outlines: connect profiles from Segment or Section"
                  : "use a larger or sharper image, lower smallest, or choose profiles by their ids")
      .parameter("profiles");
}

Chosen choose(Context& c, const Profiles& profiles, const EstimateMethod& method) {
  // The method that estimates all shapes together starts from several groups of profiles.
  const auto shapes = method.run ? static_cast<std::size_t>(c.integer("count")) : kFitHands;
  auto each = std::max(method.least, static_cast<std::size_t>(c.integer("profiles_per_shape")));
  if (method.most) each = std::min(each, method.most);
  const double crease = c.number("crease");
  Chosen out;
  auto candidates = candidates_of(profiles, candidate_options(c), c.work());
  c.metric("usable_profiles", static_cast<double>(candidates.outlines.size()));
  const std::string rule = c.keyword("profiles");
  if (!rule.empty()) {
    if (candidates.outlines.size() < each) too_few(profiles, candidates, each);
    if (method.run && candidates.outlines.size() < shapes * each)
      c.warn(fmt::format("{} shapes of {} profiles each share only {} profiles", shapes, each,
                         candidates.outlines.size()));
    const auto hands = choose_profiles(candidates.outlines, rule, shapes, each, c.seed(), c.work());
    for (const auto& hand : hands) {
      out.shapes.emplace_back();
      for (const int i : hand) out.shapes.back().push_back(candidates.outlines[i]);
    }
    out.all = std::move(candidates.outlines);
    return out;
  }
  const auto ids = c.ints("profiles");
  std::vector<Outline> outlines;
  try {
    outlines = outlines_by_id(profiles, ids, crease);
  } catch (Error& e) {
    throw e.parameter("profiles");
  }
  if (ids.size() < method.least)
    throw Error("too-few-profiles",
                fmt::format("a shape needs at least {} profiles; {} {} given", method.least, ids.size(),
                            ids.size() == 1 ? "is" : "are"),
                "list more profiles, or repeat one of them")
        .parameter("profiles");
  for (const auto id : ids)
    if (profiles.profiles[static_cast<std::size_t>(id) - 1].touches_border)
      c.warn(fmt::format("profile {} is cut by the border, so its outline is incomplete", id));
  out.by_id = true;
  out.same = outlines.size() < shapes * each || shapes == 1;
  for (std::size_t s = 0; s < shapes; ++s) {
    const auto from = outlines.begin() + static_cast<std::ptrdiff_t>(s * each);
    out.shapes.push_back(out.same ? outlines
                                  : std::vector<Outline>(from, from + static_cast<std::ptrdiff_t>(each)));
  }
  if (!out.same && outlines.size() > shapes * each)
    c.warn(fmt::format("the last {} of the {} profiles are not used", outlines.size() - shapes * each,
                       outlines.size()));
  out.all = std::move(candidates.outlines);
  return out;
}

struct Made {
  Estimate estimate;
  std::int64_t self_intersections = 0;
};

// Builds the shape as requested. If it intersects itself, tries other base curves with the same profiles.
Made make(const EstimateMethod& method, EstimateRequest request, bool any_base, const Work& work) {
  Made best;
  const int n = static_cast<int>(request.chosen.size()), first = request.base;
  for (int turn = 0; turn < (any_base ? n : 1); ++turn) {
    request.base = (first + turn) % n;
    Made made{method.run(request, work)};
    made.self_intersections = self_intersections(made.estimate.mesh, work);
    if (mesh_volume(made.estimate.mesh) <= 0)
      made.self_intersections += static_cast<std::int64_t>(made.estimate.mesh.triangles.size());
    if (turn == 0 || made.self_intersections < best.self_intersections) best = std::move(made);
    if (best.self_intersections == 0) break;
  }
  return best;
}

void compute_fit(Context& c, const Chosen& chosen) {
  if (chosen.all.size() < kFitLeast)
    throw Error(
        "too-few-profiles",
        fmt::format("fit needs at least {} usable profiles; there are {}", kFitLeast, chosen.all.size()),
        "use a larger image or several sections, lower smallest, or use another method")
        .parameter("method");
  if (chosen.all.size() < 60)
    c.warn(fmt::format("only {} profiles: the shapes will also fit sampling noise", chosen.all.size()));
  FitRequest request;
  request.hands = chosen.shapes;
  request.all = &chosen.all;
  request.count = static_cast<int>(c.integer("count"));
  request.smallest = c.number("smallest");
  request.one_size = c.text("sizes") == "equal";
  request.rounds = static_cast<int>(c.integer("rounds"));
  request.seed = c.seed();
  Fit fit = fit_bodies(request, c.work().part(0, 0.95));
  Shapes shapes;
  double triangles = 0, crossings = 0;
  for (auto& body : fit.bodies) {
    const auto crossing = static_cast<double>(self_intersections(body.mesh, c.work()));
    const std::string name = fmt::format("fit {} from {}", shapes.shapes.size() + 1, body.from);
    if (crossing > 0) c.warn(fmt::format("{} intersects itself ({} pairs of triangles)", name, crossing));
    crossings += crossing;
    triangles += static_cast<double>(body.mesh.triangles.size());
    Shape shape = measure_shape(name, std::move(body.mesh), body.probability, c.work().part(0.95, 1));
    shape.smooth = body.smooth;
    shapes.shapes.push_back(std::move(shape));
  }
  c.metric("shapes", static_cast<double>(shapes.shapes.size()));
  c.metric("triangles", triangles);
  c.metric("self_intersections", crossings);
  c.metric("start_distance", fit.start);
  c.metric("distance", fit.distance);
  c.output("shapes", std::move(shapes));
}

void compute(Context& c) {
  const auto& profiles = c.input<Profiles>("profiles");
  const auto& method = chosen_method(c, profiles);
  const std::string axis = c.text("axis");
  const Chosen chosen = choose(c, profiles, method);
  if (!method.run) return compute_fit(c, chosen);

  Shapes shapes;
  double triangles = 0, crossings = 0, deviation = -1;
  const std::size_t count = chosen.shapes.size();
  for (std::size_t s = 0; s < count; ++s) {
    const Work work = c.work().part(static_cast<double>(s) / count, (s + 1.0) / count);
    EstimateRequest request;
    request.chosen = chosen.shapes[s];
    request.all = &chosen.all;
    request.index = static_cast<int>(s);
    request.seed = c.seed();
    request.subdivision = static_cast<int>(c.integer("subdivision"));
    request.control = static_cast<int>(c.optional_integer("control").value_or(0));
    request.axis = axis != "alternate" ? axis : s % 2 == 1 ? "long" : "short";
    // If the profiles are the same again, use another one of them as the base.
    const std::size_t permutations = method.permutations ? method.permutations : request.chosen.size();
    request.base = chosen.same ? static_cast<int>(s % permutations) : 0;
    Made made = make(method, request, !chosen.same, work);
    std::string name;
    for (const auto& o : request.chosen) name += fmt::format("{}{}", name.empty() ? "profiles " : ", ", o.id);
    if (made.self_intersections > 0)
      c.warn(fmt::format("the shape of {} intersects itself ({} pairs of triangles)", name,
                         made.self_intersections));
    const Mesh& mesh = made.estimate.mesh;
    if (const auto handles = 1 - (static_cast<std::int64_t>(mesh.vertices.size()) -
                                  static_cast<std::int64_t>(mesh.triangles.size()) / 2) /
                                     2;
        handles > 0)
      c.warn(fmt::format("the shape of {} has {} handle{}", name, handles, handles == 1 ? "" : "s"));
    if (method.silhouettes && made.estimate.deviation > 0.01)
      c.warn(fmt::format(
          "the silhouettes of {} cut each other: they are reproduced only to {:.1f} % of their diameter",
          name, 100 * made.estimate.deviation));
    Shape shape = measure_shape(name, std::move(made.estimate.mesh), 1.0 / count, work);
    shape.smooth = made.estimate.smooth;
    triangles += shape.mesh.triangles.size();
    crossings += static_cast<double>(made.self_intersections);
    deviation = std::max(deviation, made.estimate.deviation);
    shapes.shapes.push_back(std::move(shape));
  }
  c.metric("shapes", static_cast<double>(count));
  c.metric("triangles", triangles);
  c.metric("self_intersections", crossings);
  if (deviation >= 0) c.metric("deviation", deviation);
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
  doc += fmt::format(" auto: fit with at least {} usable profiles, morphed_generalized_cylinder with fewer.",
                     kFitEnough);
  return Parameter::choice("method", "morphed_generalized_cylinder", names).doc_(doc);
}

}  // namespace

NodeType shape_estimate_node() {
  return NodeType("ShapeEstimate", 8)
      .doc_(
          "Estimates plausible particle shapes from the outlines of their plane sections. How the sections "
          "of different particles are arranged in space is unknown; each method makes a different "
          "assumption.")
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
      .parameter(Parameter::integer("count", 3)
                     .range(1, 100)
                     .doc_("Number of different shapes. With fit, the maximum: shapes of negligible weight "
                           "are dropped."))
      .parameter(Parameter::integer("profiles_per_shape", 3)
                     .range(1, 12)
                     .doc_("Number of profiles per shape, within the limits of the method"))
      .parameter(
          Parameter::integer("subdivision", 1)
              .range(0, 4)
              .doc_("Number of Catmull–Clark subdivision levels. Each level quadruples the number of "
                    "triangles (about 500 to 2000 at 1). With control: auto, each level also allows more "
                    "control points; grids with more than ten per quarter are subdivided only once."))
      .parameter(Parameter::optional_integer("control", "auto")
                     .range(2, 24)
                     .doc_("Number of control points per quarter of a curve. auto: the fewest that reproduce "
                           "the profiles within 0.8 % of their diameter, at most 4 + 2·subdivision, or 24 if "
                           "subdivision is 2 or more."))
      .parameter(
          Parameter::choice("axis", "auto", {"auto", "short", "long", "alternate"})
              .doc_("Orientation of profiles on the base. short: lying, for flat and equant shapes. "
                    "long: upright, for elongated shapes. auto: the one that scales the profiles less, "
                    "which is right for the principal sections of one body. alternate: short and long "
                    "in turn."))
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
      .parameter(Parameter::integer("rounds", 3)
                     .range(1, 60)
                     .doc_("Number of search rounds per shape, for method fit"))
      .parameter(Parameter::optional_integer("class", "any")
                     .range(0, 1e6)
                     .doc_("Color or particle class whose profiles are used"))
      .parameter(Parameter::seed().doc_("Random seed of the choice of profiles and of random shapes"))
      .compute_(compute);
}

}  // namespace terrazzo
