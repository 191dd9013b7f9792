#include "nodes/shapes/shape_estimate/estimate_class.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/shape_estimate/fit.h"
#include "nodes/shapes/shape_estimate/form_by_size.h"
#include "nodes/shapes/shape_estimate/from_above.h"
#include "nodes/shapes/shape_estimate/lobed.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/relief.h"
#include "nodes/shapes/shape_estimate/self_intersections.h"

namespace terrazzo::shape_estimate {
namespace {

const EstimateMethod& method_of(const std::string& name) {
  const auto& all = estimate_methods();
  return *std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == name; });
}

struct Chosen {
  std::vector<std::vector<Outline>> shapes;  // profiles of each shape
  std::vector<Outline> all;
  bool by_id = false;
  bool same = false;  // every shape uses the same profiles
  std::size_t usable = 0;
};

constexpr std::size_t kFitHands = 4;

// Stones of about one size have much in common: their axes, their roundness, and how they lie.
constexpr double kLikeSizes = 0.3;        // SizeTrend::spread of traced shapes
constexpr std::size_t kCompactLeast = 4;  // profiles of compact particles beside lobed ones

constexpr int kBodies = 3, kSilhouettes = 40;

// Shapes if `count` is auto: three bodies have the statistics of sections, but silhouettes are seen one by
// one, each of its own stones.
std::size_t count_of_shapes(const Context& c, const Profiles& profiles, std::size_t usable) {
  const auto given = c.optional_integer("count");
  if (given || profiles.view != View::Surface) return given.value_or(kBodies);
  return std::clamp<std::size_t>(usable, 1, kSilhouettes);
}

// The method that the parameter names. With auto: stones of a surface have a silhouette of the photograph,
// and flat faces if all its stones together show corners; otherwise fit if there are enough profiles.
const EstimateMethod& chosen_method(Context& c, const Profiles& profiles, const CandidateOptions& options) {
  const std::string name = c.text("method");
  if (name != "auto") return method_of(name);
  if (profiles.view == View::Surface) {
    const CandidateOptions all{-1, options.smallest};  // with the crease for which kCrushed holds
    const double corners = usual_corners(candidates_of(profiles, all, c.work()).outlines);
    c.metric("corners", corners);
    return method_of(corners > kCrushed ? "faceted" : "inflation");
  }
  if (c.keyword("profiles").empty()) return method_of("morphed_generalized_cylinder");
  const std::size_t usable = candidates_of(profiles, options, c.work()).outlines.size();
  return method_of(usable >= kFitEnough ? "fit" : "morphed_generalized_cylinder");
}

[[noreturn]] void too_few(const Profiles& profiles, const Candidates& candidates, std::size_t each) {
  const bool no_outlines =
      !profiles.profiles.empty() && candidates.without_contour == count_of(profiles.profiles);
  throw Error("too-few-profiles",
              fmt::format("a shape needs {} profiles; of the {} given: {}", each, profiles.profiles.size(),
                          candidates.text()),
              no_outlines
                  ? "these profiles are areas without outlines: connect profiles from Segment or Section"
                  : "use a larger or sharper image, lower smallest, or choose profiles by their ids")
      .parameter("profiles");
}

Chosen choose(Context& c, const Profiles& profiles, const EstimateMethod& method,
              const CandidateOptions& options) {
  auto each = std::max<std::size_t>(method.least, c.integer("profiles_per_shape"));
  if (method.most) each = std::min(each, method.most);
  const double crease = c.number("crease");
  Chosen out;
  auto candidates = candidates_of(profiles, options, c.work());
  out.usable = candidates.outlines.size();
  // Where stones are round, other outlines are wrong.
  if (method.lies && usual_relief(candidates.outlines) < kRound)
    std::erase_if(candidates.outlines, [](const Outline& o) { return relief_of(o) >= kRound; });
  // The method that estimates all shapes together starts from several groups of profiles.
  const auto shapes_from = [&](std::size_t outlines) {
    return method.run ? count_of_shapes(c, profiles, outlines / each) : kFitHands;
  };
  const std::string rule = c.keyword("profiles");
  if (!rule.empty()) {
    const std::size_t shapes = shapes_from(candidates.outlines.size());
    if (candidates.outlines.size() < each) too_few(profiles, candidates, each);
    if (method.run && candidates.outlines.size() < shapes * each)
      c.warn(fmt::format("{} shapes of {} profiles each share only {} profiles", shapes, each,
                         candidates.outlines.size()));
    const bool traced = method.lies && profiles.view == View::Surface;
    const auto hands =
        choose_profiles(candidates.outlines, traced && rule == "representative" ? "each_size" : rule, shapes,
                        each, c.seed(), c.work());
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
    if (profiles.profiles[id - 1].touches_border)
      c.warn(fmt::format("profile {} is cut by the border, so its outline is incomplete", id));
  const std::size_t shapes = shapes_from(ids.size());
  out.by_id = true;
  out.same = outlines.size() < shapes * each || shapes == 1;
  for (std::size_t s = 0; s < shapes; ++s) {
    const auto from = outlines.begin() + (s * each);
    out.shapes.push_back(out.same ? outlines : std::vector<Outline>(from, from + each));
  }
  if (!out.same && outlines.size() > shapes * each)
    c.warn(fmt::format("the last {} of the {} profiles are not used", outlines.size() - shapes * each,
                       outlines.size()));
  out.all = std::move(candidates.outlines);
  return out;
}

struct Attempt {
  Estimate estimate;
  std::int64_t self_intersections = 0;
};

// Builds the shape as requested. If it intersects itself, tries other base curves with the same profiles.
Attempt attempt(const EstimateMethod& method, EstimateRequest request, bool any_base, const Work& work) {
  Attempt best;
  const int n = request.chosen.size(), first = request.base;
  for (int turn = 0; turn < (any_base ? n : 1); ++turn) {
    request.base = (first + turn) % n;
    Attempt made{method.run(request, work)};
    // Bodies that lie have one height above and one below each point of the plane.
    if (!method.lies) made.self_intersections = self_intersections(made.estimate.mesh, work);
    if (mesh_volume(made.estimate.mesh) <= 0)
      made.self_intersections += static_cast<std::int64_t>(made.estimate.mesh.triangles.size());
    if (turn == 0 || made.self_intersections < best.self_intersections) best = std::move(made);
    if (best.self_intersections == 0) break;
  }
  return best;
}

// The height of stones relative to the shorter axis that a surface shows; none for sections.
std::optional<double> thickness_of(Context& c, const Profiles& profiles, const Chosen& chosen) {
  if (profiles.view != View::Surface) return {};
  const auto given = c.optional_number("thickness");
  const double thickness = given.value_or(assumed_thickness(chosen.all));
  c.metric("thickness", thickness);
  return thickness;
}

ClassEstimate estimate_fit(Context& c, const Chosen& chosen, std::optional<double> thickness,
                           const Work& work) {
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
  request.count = c.optional_integer("count").value_or(kBodies);
  request.smallest = c.number("smallest");
  request.one_size = c.text("sizes") == "equal";
  request.from_above = thickness.has_value();
  request.thickness = thickness.value_or(1);
  request.rounds = c.integer("rounds");
  request.seed = c.seed();
  Fit fit = fit_bodies(request, work.part(0, 0.95));
  ClassEstimate out;
  for (auto& body : fit.bodies) {
    const double crossing = self_intersections(body.mesh, work);
    const std::string name = fmt::format("fit {} from {}", out.shapes.size() + 1, body.from);
    if (crossing > 0) c.warn(fmt::format("{} intersects itself ({} pairs of triangles)", name, crossing));
    out.self_intersections += crossing;
    out.triangles += body.mesh.triangles.size();
    Shape shape = measure_shape(name, std::move(body.mesh), body.probability, work.part(0.95, 1));
    shape.smooth = body.smooth;
    out.shapes.push_back(std::move(shape));
  }
  out.start_distance = fit.start;
  out.distance = fit.distance;
  return out;
}

ClassEstimate estimate_each(Context& c, const EstimateMethod& method, const Chosen& chosen,
                            std::optional<double> thickness, const Work& all_work) {
  // The base of a stone that lies flat is its silhouette.
  const std::string axis = thickness && c.text("axis") == "auto" ? "short" : c.text("axis");
  std::vector<Outline> outlines = chosen.all;
  if (outlines.empty())
    for (const auto& own : chosen.shapes) outlines.insert(outlines.end(), own.begin(), own.end());
  const double relief = method.lies ? usual_relief(outlines) : 0;
  ClassEstimate out;
  const std::size_t count = chosen.shapes.size();
  for (std::size_t s = 0; s < count; ++s) {
    const Work work = all_work.part(static_cast<double>(s) / count, (s + 1.0) / count);
    EstimateRequest request;
    request.chosen = chosen.shapes[s];
    request.all = &chosen.all;
    request.index = s;
    request.seed = c.seed();
    request.subdivision = c.integer("subdivision");
    request.control = c.optional_integer("control").value_or(0);
    request.tessellation = c.choice<Tessellation>("tessellation");
    request.relief = relief;
    request.axis = axis != "alternate" ? axis : s % 2 == 1 ? "long" : "short";
    // If the profiles are the same again, use another one of them as the base.
    const std::size_t permutations = method.permutations ? method.permutations : request.chosen.size();
    request.base = chosen.same ? static_cast<int>(s % permutations) : 0;
    Attempt made = attempt(method, request, !chosen.same, work);
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
    if (thickness) {
      // The base of a cylinder already lies in the picture.
      const bool cylinder = method.name.find("cylinder") != std::string::npos;
      if (!method.lies && !(cylinder && request.axis == "short")) lie_down(made.estimate.mesh);
      give_thickness(made.estimate.mesh, *thickness);
    }
    const Vec2 before = made.estimate.mesh.vertices[0].head<2>();
    Shape shape = measure_shape(name, std::move(made.estimate.mesh), 1.0 / count, work);
    shape.smooth = made.estimate.smooth;
    if (method.lies && thickness) {  // of a surface
      const Outline& o = request.chosen[0];
      shape.traced.profile = o.id;
      shape.trend = {0, shape.size(), kLikeSizes};
      shape.traced.turn = o.turn;
      shape.traced.faceted = method.name == "faceted";
      shape.traced.origin =
          o.center + Eigen::Rotation2Dd(o.turn) * Vec2(before - shape.mesh.vertices[0].head<2>());
    }
    out.triangles += shape.mesh.triangles.size();
    out.self_intersections += made.self_intersections;
    out.deviation = std::max(out.deviation, made.estimate.deviation);
    out.shapes.push_back(std::move(shape));
  }
  return out;
}

// Compact and lobed bodies, whose shares depend on the size, if the profiles tell both apart.
std::optional<ClassEstimate> estimate_by_form(Context& c, const Profiles& profiles,
                                              const CandidateOptions& options, const Work& work) {
  const std::vector<Outline> all = candidates_of(profiles, options, work).outlines;
  if (all.empty()) return {};
  const ProfileMeasuring how = measuring_of(all);
  const auto forms = forms_of(all, how);
  const std::size_t least = std::max<std::size_t>(kCompactLeast, c.integer("profiles_per_shape"));
  if (!forms || all.size() - forms->not_compact.size() < least) return {};
  CandidateOptions others = options;
  others.without = forms->not_compact;
  ClassEstimate out = estimate_class(c, profiles, others, work.part(0, 0.7));
  std::vector<Shape> bodies;
  const int count = c.optional_integer("count").value_or(kBodies);
  for (Mesh& mesh : lobed_bodies(forms->large, how, count, c.seed(), work.part(0.7, 0.9)))
    bodies.push_back(
        measure_shape(fmt::format("lobed {}", bodies.size() + 1), std::move(mesh), 1, work.quiet()));
  std::vector<SeenProfile> seen;
  for (std::size_t i = 0; i < all.size(); ++i)
    seen.push_back({std::sqrt(4 * all[i].area / std::numbers::pi), profiles.profiles[all[i].id - 1].weight,
                    forms->lobed[i] != 0});
  const LobedShare share = lobed_share(seen, out.shapes, bodies, how, work.part(0.9, 1));
  if (!share.any) return {};
  const double part = 1 / (1 + std::exp(-share.level));
  for (Shape& s : out.shapes) s.probability *= 1 - part;
  for (Shape& s : bodies) {
    s.probability = part / bodies.size();
    s.trend = {share.trend, share.middle};
    s.smooth = true;
    out.triangles += s.mesh.triangles.size();
    out.shapes.push_back(std::move(s));
  }
  out.usable = all.size();
  out.lobed = part;
  return out;
}

}  // namespace

ClassEstimate estimate_class(Context& c, const Profiles& profiles, const CandidateOptions& options,
                             const Work& work) {
  if (c.text("method") == "auto" && profiles.view != View::Surface && !c.keyword("profiles").empty() &&
      options.without.empty())
    if (auto out = estimate_by_form(c, profiles, options, work)) return *std::move(out);
  const EstimateMethod& method = chosen_method(c, profiles, options);
  const Chosen chosen = choose(c, profiles, method, options);
  const auto thickness = thickness_of(c, profiles, chosen);
  ClassEstimate out = method.run ? estimate_each(c, method, chosen, thickness, work)
                                 : estimate_fit(c, chosen, thickness, work);
  out.usable = chosen.usable;
  return out;
}

}  // namespace terrazzo::shape_estimate
