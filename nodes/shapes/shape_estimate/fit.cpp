#include "nodes/shapes/shape_estimate/fit.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/reduce.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/shapes/shape_estimate/feature_match.h"
#include "nodes/shapes/shape_estimate/from_above.h"
#include "nodes/shapes/shape_estimate/least_squares.h"
#include "nodes/shapes/shape_estimate/methods/body_family.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/self_intersections.h"
#include "nodes/shapes/shape_estimate/size_selection.h"

namespace terrazzo::shape_estimate {

namespace {

// Planes per trial: the number of profiles within these bounds; a longer search may use more. Fewer tell
// which family is best. kLastPlanes: planes for the final bodies.
constexpr std::size_t kLeastPlanes = 144, kPlanesPerRound = 85, kMostPlanes = 512;
constexpr std::size_t kPlanesOfFamilies = 72, kLastPlanes = 1536;
constexpr std::size_t kMostTriangles = 1500;  // of a body: sections of more do not differ from these
constexpr std::size_t kHands = 4;
constexpr int kGuesses = 96;  // number of starting bodies of each modeled family

struct Start {
  Mesh mesh;
  std::string from;
  double distance = 0;
};

// Bodies from the other methods; those of the cylinders both lying and upright.
std::vector<Start> starting_bodies(const FitRequest& request, const Work& work) {
  struct Task {
    std::size_t hand;
    const EstimateMethod* method;
    const char* axis;
  };
  std::vector<Task> tasks;
  for (std::size_t h = 0; h < std::min(kHands, request.hands.size()); ++h)
    for (const auto& m : estimate_methods()) {
      // Extruded silhouettes touch themselves; polyhedra are as sharp.
      if (!m.run || m.lies || m.silhouettes || request.hands[h].size() < m.least) continue;
      for (const char* axis : {"short", "long"}) {
        const bool turns = m.name.find("cylinder") != std::string::npos;
        if (turns || axis[0] == 's') tasks.push_back({h, &m, axis});
      }
    }
  std::vector<std::optional<Start>> made(tasks.size());
  work.parallel(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      EstimateRequest r;
      r.chosen = request.hands[tasks[i].hand];
      r.all = request.all;
      r.index = tasks[i].hand;
      r.seed = request.seed;
      r.subdivision = 1;
      r.axis = tasks[i].axis;
      try {
        Mesh mesh = tasks[i].method->run(r, work.quiet()).mesh;
        // The deformations cannot remove self-intersections.
        if (mesh_volume(mesh) > 0 && self_intersections(mesh, work.quiet()) == 0)
          made[i] = Start{std::move(mesh), tasks[i].method->name, 0};
      } catch (const Error&) {
        // This method cannot use these profiles; the others can.
      }
    }
  });
  std::vector<Start> out;
  for (auto& m : made)
    if (m) out.push_back(std::move(*m));
  return out;
}

// The body at x, or closer to the starting body if it passes through itself at more places than that:
// sharpening is not a map of space. Triangles of a starting body may touch within rounding.
Mesh simple_body(const BodyFamily& family, const Eigen::VectorXd& x, const Work& work) {
  Mesh start = family.body(Eigen::VectorXd::Zero(x.size()));
  const std::int64_t touching = self_intersections(start, work.quiet());
  for (const double share : {1.0, 0.9, 0.8, 0.65, 0.5, 0.25}) {
    Mesh body = family.body(share * x);
    if (!body.triangles.empty() && self_intersections(body, work.quiet()) <= touching) return body;
  }
  return start;
}

// Rescales the weights of a sample to its share of a mixture.
FeatureSample with_share(FeatureSample s, double share) {
  const double total = total_weight(s);
  for (double& w : s.weight) w *= share / total;
  return s;
}

void append(FeatureSample& to, const FeatureSample& s) {
  to.features.insert(to.features.end(), s.features.begin(), s.features.end());
  to.root_area.insert(to.root_area.end(), s.root_area.begin(), s.root_area.end());
  to.weight.insert(to.weight.end(), s.weight.begin(), s.weight.end());
}

// Shares ≥ 0 with sum 1 for which the mixture's distribution functions are closest to the observed ones, by
// projected gradient. A small ridge draws them to equal shares, because the observed profiles are a sample.
std::vector<double> shares_of(const FeatureTarget& target, const std::vector<FeatureSample>& samples) {
  const Eigen::Index n = samples.size();
  const auto importance = target.importance();
  const auto& goal = target.observed_cumulative();
  Eigen::MatrixXd a(goal.size(), n);
  Eigen::VectorXd b(goal.size());
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto f = target.cumulative(samples[k]);
    for (std::size_t i = 0; i < goal.size(); ++i) a(i, k) = std::sqrt(importance[i]) * f[i];
  }
  for (std::size_t i = 0; i < goal.size(); ++i) b[i] = std::sqrt(importance[i]) * goal[i];
  Eigen::MatrixXd h = a.transpose() * a;
  h.diagonal().array() += 0.02;
  const Eigen::VectorXd g = a.transpose() * b + Eigen::VectorXd::Constant(n, 0.02 / n);
  Eigen::VectorXd w = Eigen::VectorXd::Constant(n, 1.0 / n);
  const double step = 1 / h.trace();
  for (int i = 0; i < 20000; ++i) {
    const Eigen::VectorXd moved = w - step * (h * w - g);
    // Project onto the simplex (Held, Wolfe, Crowder 1974).
    std::vector<double> sorted(moved.data(), moved.data() + n);
    std::sort(sorted.rbegin(), sorted.rend());
    double sum = 0, level = 0;
    for (std::size_t k = 0; k < sorted.size(); ++k) {
      sum += sorted[k];
      const double t = (sum - 1) / (k + 1);
      if (sorted[k] > t) level = t;
    }
    w = (moved.array() - level).max(0.0);
  }
  return {w.data(), w.data() + n};
}

// The profiles, and how their outlines and those of sections of bodies are measured alike.
struct Observation {
  ProfileMeasuring measuring;
  std::vector<double> sizes;  // root areas of all profiles
  FeatureSample sample;       // of the profiles that are not excluded
};

Observation observe(const std::vector<Outline>& all) {
  Observation observed;
  observed.measuring = measuring_of(all);
  std::vector<double> convexity;
  for (const Outline& o : all) {
    convexity.push_back(o.convexity);
    observed.sizes.push_back(std::sqrt(o.area));
  }
  // In a photograph, profiles that are far less convex than others are excluded as merged ones.
  std::sort(convexity.begin(), convexity.end());
  const double lower = convexity[convexity.size() / 4], upper = convexity[3 * convexity.size() / 4];
  const double least_convex = observed.measuring.blur > 0 ? lower - 3 * (upper - lower) : 0;

  for (const Outline& o : all) {
    if (o.convexity < least_convex) continue;
    const ProfileFeatures f = profile_features(o, observed.measuring);
    if (f[OutlineFeature::Circularity] <= 0) continue;
    observed.sample.features.push_back(f);
    observed.sample.root_area.push_back(std::sqrt(o.area));
    observed.sample.weight.push_back(1);
  }
  return observed;
}

std::size_t planes_per_trial(const FitRequest& request, std::size_t profiles) {
  const std::size_t most = std::clamp(kPlanesPerRound * request.rounds, kLeastPlanes, kMostPlanes);
  return request.planes ? request.planes : std::clamp(profiles, kLeastPlanes, most);
}

// What a photograph shows of a body.
std::vector<CutProfile> shown(const Mesh& mesh, std::size_t planes, bool from_above) {
  return from_above ? seen_from_above(mesh, planes) : cut_sections(mesh, planes);
}

// Sections of bodies, as the profiles would show them.
struct SectionSampling {
  ProfileMeasuring measuring;
  SizeSelection selection;
  bool from_above;

  FeatureSample measure(std::vector<CutProfile> sections) const {
    selection.apply(sections);
    return measured(sections, measuring);
  }
  FeatureSample sample(const Mesh& mesh, std::size_t planes) const {
    return measure(shown(mesh, planes, from_above));
  }
};

// Puts the starting bodies first whose sections are closest to the profiles.
void sort_starts(std::vector<Start>& starts, std::vector<std::vector<CutProfile>> sections,
                 const FeatureTarget& target, const SectionSampling& sampling) {
  for (std::size_t i = 0; i < starts.size(); ++i)
    starts[i].distance = target.distance(sampling.measure(std::move(sections[i])));
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.distance < b.distance; });
}

enum class FamilyKind { Deformed, Faceted, Modeled };

// A modeled starting body.
struct Guess {
  FamilyKind kind;
  int number;
  FeatureSample sample;  // empty: used before
  std::shared_ptr<const SwellingBall> ball = {};

  std::unique_ptr<BodyFamily> family(std::uint64_t seed) const {
    return kind == FamilyKind::Faceted ? faceted_bodies(seed, number) : modeled_bodies(seed, number, ball);
  }
};

std::vector<Guess> make_guesses(const SectionSampling& sampling, std::size_t planes, std::uint64_t seed,
                                const Work& work) {
  std::vector<Guess> guesses;
  const auto ball = swelling_ball(seed);
  for (const FamilyKind kind : {FamilyKind::Modeled, FamilyKind::Faceted})
    for (int i = 0; i < kGuesses; ++i) guesses.push_back({kind, i, {}, ball});
  work.parallel(guesses.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto family = guesses[i].family(seed);
      guesses[i].sample = sampling.sample(family->body(Eigen::VectorXd::Zero(family->dimensions())), planes);
    }
  });
  return guesses;
}

// A search within one family of bodies.
struct FamilySearch {
  std::unique_ptr<BodyFamily> family;
  std::string from;
  FamilyKind kind;
  LeastSquares at;
  int guess = -1;  // index of a modeled body
};

// Finds one body after another. Each is compared with the profiles together with those before it.
class BodySearch {
 public:
  BodySearch(const FitRequest& request, const FeatureTarget& target, const SectionSampling& sampling,
             std::size_t planes, const std::vector<Start>& starts, std::vector<Guess> guesses)
      : request_(request),
        target_(target),
        sampling_(sampling),
        planes_(planes),
        starts_(starts),
        guesses_(std::move(guesses)) {}

  // Body k, after bodies 0 … k − 1.
  FittedBody next(int k, const Work& work) {
    // A round with each promising start, then the remaining rounds with the best.
    std::vector<FamilySearch> searches = promising(k);
    for (std::size_t i = 0; i < searches.size(); ++i) {
      searches[i].at.x = Eigen::VectorXd::Zero(searches[i].family->dimensions());
      const double share = 0.5 / searches.size();
      const Work part = work.part(share * i, share * (i + 1));
      improve(searches[i], k, 1, 0.4, std::min(planes_, kPlanesOfFamilies), work, part);
    }
    FamilySearch& best = *std::min_element(
        searches.begin(), searches.end(),
        [](const FamilySearch& a, const FamilySearch& b) { return a.at.value < b.at.value; });
    improve(best, k, request_.rounds, 0.25, planes_, work, work.part(0.5, 1));
    if (k == 0) first_kind_ = best.kind;
    // Do not start from the same guess again.
    if (best.guess >= 0) guesses_[best.guess].sample = {};
    FittedBody body{simple_body(*best.family, best.at.x, work), 0, best.kind != FamilyKind::Faceted,
                    best.from};
    // All bodies so far have equal shares of the profiles.
    const FeatureSample own = with_share(sampling_.sample(body.mesh, planes_), 1.0 / (k + 2));
    for (double& w : before_.weight) w *= (k + 1.0) / (k + 2);
    append(before_, own);
    return body;
  }

 private:
  // The searches that compete for body k.
  std::vector<FamilySearch> promising(int k) const {
    std::vector<FamilySearch> searches;
    if (k == 0) {
      for (std::size_t s = 0; s < std::min<std::size_t>(starts_.size(), 2); ++s)
        searches.push_back(deformed(s, k));
      searches.push_back(cut(0, k));
      add_guesses(FamilyKind::Faceted, 1, k, searches);
    } else if (first_kind_ == FamilyKind::Deformed) {
      searches.push_back(deformed(k, k));
    } else {
      add_guesses(FamilyKind::Faceted, 1, k, searches);
    }
    add_guesses(FamilyKind::Modeled, 1, k, searches);
    return searches;
  }

  FamilySearch deformed(std::size_t i, int k) const {
    const Start& start = starts_[i % starts_.size()];
    return {deformed_bodies(start.mesh, request_.seed + k), start.from, FamilyKind::Deformed, {}, -1};
  }

  FamilySearch cut(std::size_t i, int k) const {
    const Start& start = starts_[i % starts_.size()];
    return {faceted_bodies(start.mesh, request_.seed + k), start.from + ", cut", FamilyKind::Faceted, {}, -1};
  }

  // Adds the `most` guesses of a family that are closest to the profiles.
  void add_guesses(FamilyKind kind, std::size_t most, int k, std::vector<FamilySearch>& searches) const {
    std::vector<std::pair<double, int>> order;
    for (std::size_t g = 0; g < guesses_.size(); ++g)
      if (guesses_[g].kind == kind && !guesses_[g].sample.features.empty())
        order.emplace_back(target_.distance(with_those_before(guesses_[g].sample, k)), static_cast<int>(g));
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < std::min(most, order.size()); ++i) {
      const Guess& guess = guesses_[order[i].second];
      searches.push_back({guess.family(request_.seed),
                          kind == FamilyKind::Faceted ? "a polyhedron" : "a ball",
                          kind,
                          {},
                          order[i].second});
    }
  }

  FeatureSample with_those_before(FeatureSample s, int k) const {
    if (k > 0 && !s.features.empty()) {
      s = with_share(std::move(s), 1.0 / (k + 1));
      append(s, before_);
    }
    return s;
  }

  // `body`: of the whole search for body k; it is only asked whether to stop.
  void improve(FamilySearch& search, int k, int rounds, double step, std::size_t planes, const Work& body,
               const Work& work) const {
    LeastSquaresOptions options;
    options.rounds = rounds;
    options.step = step;
    const auto residuals = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      body.check();
      const Mesh mesh = search.family->body(x);
      if (mesh.triangles.empty()) return {};
      return target_.residuals(with_those_before(sampling_.sample(mesh, planes), k));
    };
    search.at = least_squares(residuals, search.at.x, options, work, std::move(search.at.slope));
  }

  const FitRequest& request_;
  const FeatureTarget& target_;
  const SectionSampling& sampling_;
  std::size_t planes_;
  const std::vector<Start>& starts_;
  std::vector<Guess> guesses_;
  FeatureSample before_;                          // of the bodies found
  FamilyKind first_kind_ = FamilyKind::Deformed;  // family that won for the first body
};

// Gives the bodies their shares by number and the size of the particles, and drops those of negligible share.
void mix(Fit& fit, const FeatureTarget& target, const SectionSampling& sampling, const Work& work) {
  std::vector<FittedBody>& bodies = fit.bodies;
  std::vector<FeatureSample> samples(bodies.size());
  work.parallel(bodies.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) samples[i] = sampling.sample(bodies[i].mesh, kLastPlanes);
  });
  const auto shares = shares_of(target, samples);
  FeatureSample together;
  double mean = 0, sum = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (shares[i] <= 0) continue;
    // Convert shares of profiles to shares by number: divide by how many profiles one body shows.
    bodies[i].probability = shares[i] / total_weight(samples[i]);
    sum += bodies[i].probability;
    append(together, with_share(samples[i], shares[i]));
  }
  for (std::size_t i = 0; i < together.weight.size(); ++i) mean += together.weight[i] * together.root_area[i];
  mean /= total_weight(together);
  fit.distance = target.distance(together);
  const double scale = target.mean_root_area() / mean;
  std::vector<FittedBody> kept;
  for (FittedBody& body : bodies) {
    if (body.probability / sum < 1e-3) continue;
    for (auto& v : body.mesh.vertices) v *= scale;
    body.probability /= sum;
    kept.push_back(std::move(body));
  }
  fit.bodies = std::move(kept);
}

}  // namespace

Fit fit_bodies(const FitRequest& request, const Work& work) {
  const Observation observed = observe(*request.all);
  const std::size_t planes = planes_per_trial(request, observed.sample.features.size());
  const FeatureTarget target(observed.sample, request.one_size, request.seed);

  auto starts = starting_bodies(request, work.part(0, 0.05));
  if (request.from_above)
    for (Start& s : starts) lie_down(s.mesh);
  if (starts.empty())
    throw Error("no-start", "none of the other methods can build a body from these profiles",
                "check the profiles, or choose others by their ids");
  std::vector<std::vector<CutProfile>> started(starts.size());
  work.part(0.05, 0.08).parallel(starts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) started[i] = shown(starts[i].mesh, planes, request.from_above);
  });
  const SectionSampling sampling{observed.measuring,
                                 request.one_size ? SizeSelection(request.smallest, target.mean_root_area())
                                                  : SizeSelection(observed.sizes, started),
                                 request.from_above};
  sort_starts(starts, std::move(started), target, sampling);

  Fit fit;
  fit.start = starts[0].distance;
  BodySearch search(
      request, target, sampling, planes, starts,
      make_guesses(sampling, std::min(planes, kLeastPlanes), request.seed, work.part(0.08, 0.15)));
  for (int k = 0; k < request.count; ++k) {
    const double from = 0.15 + 0.83 * k / request.count;
    fit.bodies.push_back(search.next(k, work.part(from, from + 0.83 / request.count)));
  }
  for (FittedBody& body : fit.bodies) reduce_triangles(body.mesh, kMostTriangles, work.quiet());
  mix(fit, target, sampling, work.part(0.98, 1));
  if (request.from_above)
    for (FittedBody& body : fit.bodies) give_thickness(body.mesh, request.thickness);
  return fit;
}

}  // namespace terrazzo::shape_estimate
