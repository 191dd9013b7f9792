#include "nodes/sizes/unfolding/unfold.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/sizes/unfolding/bootstrap.h"
#include "nodes/sizes/unfolding/em.h"
#include "nodes/sizes/unfolding/solve.h"

namespace terrazzo::unfolding {
namespace {

using Eigen::VectorXd;

// By how much such errors can lift the volume fraction above 1.
constexpr double kOverfull = 0.02;

// Smallest distance between the density and the ends of its interval, in profiles. Above: a Poisson mean of 3
// shows none one time in twenty. Below: fewer cannot be seen.
constexpr double kAbove = 3, kBelow = 1.5;

// Of loose stones, Segment recognizes the smallest parts by chance: those below this many times the smallest
// are left out (results, Views).
constexpr double kRecognized = 1.3;

double smallest_seen(const Observations& o) {
  double smallest = o.largest;
  for (const auto& c : o.classes)
    for (const double s : c.size) smallest = std::min(smallest, s);
  return smallest * (1 - 1e-9);
}

// Of a surface, at least half of the silhouettes count, and all whole ones of the largest stones.
double visible_in(const Observations& o, Bed bed) {
  double visible = smallest_seen(o);
  if (bed == Bed::None) return visible;
  if (bed == Bed::Loose) {
    std::vector<double> sizes;
    for (const auto& c : o.classes) sizes.insert(sizes.end(), c.size.begin(), c.size.end());
    visible = std::min(kRecognized * visible, median(std::move(sizes)));
  }
  return std::min(visible, kSmallestWhole * o.largest);
}

struct ClassFit {
  UnfoldFit fit;
  Intervals intervals;
};

// One color class. `em_model` is null for the other methods.
ClassFit fit_class(const Observations& o, const UnfoldModel& m, std::size_t c, const UnfoldOptions& options,
                   const EmModel* em_model, const Work& work) {
  const Observation& q = o.classes[c];
  ClassFit out;
  UnfoldFit& fit = out.fit;
  const Counts counts = count(q.size, q.weight, m.profile_edges);
  fit.observed = counts.sum / o.area;

  EmFit em;
  if (em_model) {
    em = fit_em(*em_model, q, o.area, kFractionError, work.part(0, 0.3));
    fit.density = em_model->reclass * em.density;
    fit.refitted = em_model->coarse * em.density;
    for (const auto& f : em.fits) {
      fit.freedom += f.weight * f.freedom;
      fit.jumps += f.weight * f.breaks.size();
    }
  } else {
    if (options.method == Method::Nnls) {
      fit.density = solve_nnls(m, counts, o.area, q.area_fraction, kFractionError);
    } else {
      const VectorXd x = solve_inverse(m, fit.observed);
      fit.negative = x.cwiseMin(0).cwiseAbs().sum() / std::max(x.cwiseAbs().sum(), 1e-300);
      fit.density = x.cwiseMax(0);
    }
    fit.refitted = m.matrix * fit.density;
    fit.freedom = (fit.density.array() > 0).count();
  }
  if (options.bootstrap == 0 || q.size.empty()) return out;

  out.intervals = bootstrap(
      q, o.sections, options.bootstrap, options.seed, c,
      [&](const std::vector<double>& weights, double drawn, Random& random) -> VectorXd {
        if (em_model) return draw_em(*em_model, em, q, weights, o.area, drawn, kFractionError, random);
        const Counts again = count(q.size, weights, m.profile_edges);
        if (options.method == Method::Nnls)
          return solve_nnls(m, again, o.area, q.area_fraction * drawn, kFractionError);
        return solve_inverse(m, again.sum / o.area).cwiseMax(0);
      },
      work.part(0.3, 1));
  std::vector<char> empty(m.visible(), false);
  if (em_model) empty = may_be_empty(*em_model, em, q, o.area, work);
  for (int j = 0; j < m.visible(); ++j) {
    auto& low = out.intervals.low[j];
    auto& high = out.intervals.high[j];
    const double profile = 1 / (m.matrix.col(j).sum() * o.area);
    low = empty[j] ? 0 : std::max(0.0, std::min(low, fit.density[j] - kBelow * profile));
    high = std::max(high, fit.density[j] + kAbove * profile);
  }
  return out;
}

// Adds the error of the law of hiding to intervals, which contain that of counting.
void add_hiding_error(ClassFit& f) {
  constexpr double kOneSided = 1.645;  // standard deviations, of a 90 % interval
  for (std::size_t j = 0; j < f.intervals.low.size(); ++j) {
    const double density = f.fit.density[j], error = kOneSided * kHidingError * density;
    auto& low = f.intervals.low[j];
    auto& high = f.intervals.high[j];
    low = std::max(0.0, density - std::hypot(density - low, error));
    high = density + std::hypot(high - density, error);
  }
}

void add_entries(SizeDistribution& out, const KMatrix& k, const UnfoldModel& m, std::size_t c,
                 const ClassFit& f) {
  std::vector<std::vector<double>> shares;
  for (int j = m.first; j < m.classes(); ++j)
    shares.push_back(shape_shares(k, (m.edges[j] + m.edges[j + 1]) / 2));
  for (std::size_t s = 0; s < k.shapes.size(); ++s) {
    if (!(k.shapes[s].probability > 0)) continue;
    SizeDistribution::Entry e;
    e.shape = s;
    e.cls = c;
    e.N_V.assign(m.classes(), 0);
    for (int j = 0; j < m.visible(); ++j) e.N_V[m.first + j] = shares[j][s] * f.fit.density[j];
    e.low = e.high = e.N_V;
    for (std::size_t j = 0; j < f.intervals.low.size(); ++j) {
      e.low[m.first + j] = shares[j][s] * f.intervals.low[j];
      e.high[m.first + j] = shares[j][s] * f.intervals.high[j];
    }
    out.shapes.push_back(std::move(e));
  }
}

void divide_densities(UnfoldResult& r, double by) {
  for (auto& f : r.fits) {
    f.density /= by;
    f.refitted /= by;
  }
  for (auto& e : r.distribution.shapes)
    for (auto* values : {&e.N_V, &e.low, &e.high})
      for (double& v : *values) v /= by;
}

// Without an area, densities are known only up to a factor: scale them to Σ N_V = 1 and leave
// the volume fraction unknown.
void make_relative(UnfoldResult& r) {
  double sum = 0;
  for (const auto& f : r.fits) sum += f.density.sum();
  if (!(sum > 0)) return;
  for (auto& f : r.fits) f.observed /= sum;
  divide_densities(r, sum);
  r.distribution.volume_fraction = 0;
}

// Particles that fill space, as in a polycrystal, come out up to some errors of the area fraction too many.
void make_room(UnfoldResult& r) {
  double& fraction = r.distribution.volume_fraction;
  if (fraction <= 1 || fraction > 1 + kOverfull) return;
  divide_densities(r, fraction);
  fraction = 1;
}

// Counts tell the volume fraction of loose stones with the error of the law of hiding, and physics with
// kLooseError: the mean of both, weighted by their precision.
void hold_to_loose_fraction(UnfoldResult& r) {
  constexpr double kCounts = kHidingError * kHidingError, kPhysics = kLooseError * kLooseError;
  double& fraction = r.distribution.volume_fraction;
  if (!(fraction > 0)) return;
  const double factor = std::pow(kLooseFraction / fraction, kCounts / (kCounts + kPhysics));
  divide_densities(r, 1 / factor);
  fraction *= factor;
}

bool is_finite(const UnfoldResult& r) {
  bool all = std::isfinite(r.distribution.volume_fraction);
  for (const auto& f : r.fits) all = all && f.density.allFinite();
  return all;
}

Bed bed_of(const Profiles& profiles) {
  if (profiles.view != View::Surface) return Bed::None;
  return shows_loose_stones(profiles) ? Bed::Loose : Bed::Soil;
}

// Unfolds with a given number of size classes.
UnfoldResult unfold_classes(Observations o, int classes, double visible, const KMatrix& k,
                            const UnfoldOptions& options, Bed bed, const Work& work) {
  UnfoldResult r;
  double d_max = options.d_max;
  if (d_max > 0 && d_max < o.largest * (1 - 1e-9))
    throw Error(
        "too-small",
        fmt::format("d_max must be at least the size of the largest profile, {:.4g} mm; it is {:.4g} mm",
                    o.largest, d_max),
        "raise d_max, or set it to auto")
        .parameter("d_max");
  if (options.types == Types::ByClass && o.classes.size() > k.shapes.size())
    throw Error("wrong-count",
                fmt::format("the profiles have {} color classes, but the K matrix has {} shapes",
                            o.classes.size(), k.shapes.size()),
                "connect one shape per class, or set types: mixed")
        .parameter("types");
  if (d_max <= 0 && bed != Bed::None) d_max = o.largest * (1 + 1e-9);  // silhouettes show whole sizes
  if (d_max <= 0) d_max = estimate_d_max(o, k, options.types, classes, visible, work.part(0, 0.3));
  std::vector<double> profiles;
  if (options.classes == 0 && options.method == Method::Em)
    for (const auto& q : o.classes) profiles.insert(profiles.end(), q.size.begin(), q.size.end());
  r.model = make_model(k, classes, d_max, visible, profiles, bed);
  const UnfoldModel& m = r.model;
  r.condition = condition_of(m.matrix);
  const bool em = options.method == Method::Em;

  SizeDistribution& out = r.distribution;
  out.class_edges = m.edges;
  out.d_max = d_max;
  double chi2 = 0, freedom = 0;
  const double count_of_classes = o.classes.size();
  for (std::size_t c = 0; c < o.classes.size(); ++c) {
    const auto at = [&](std::size_t i) { return 0.3 + 0.7 * i / count_of_classes; };
    const KMatrix own = kmatrix_of(k, options.types, c);
    const UnfoldModel model =
        depends_on_class(k, options.types) ? make_model(own, classes, d_max, visible, profiles, bed) : m;
    const EmModel em_model = em ? make_em_model(own, model, bed) : EmModel{};
    ClassFit f = fit_class(o, model, c, options, em ? &em_model : nullptr, work.part(at(c), at(c + 1)));
    if (bed != Bed::None) add_hiding_error(f);
    for (Eigen::Index i = 0; i < f.fit.observed.size(); ++i) {
      const double expected = f.fit.refitted[i] * o.area, seen = f.fit.observed[i] * o.area;
      if (expected > 0) {
        chi2 += std::pow(seen - expected, 2) / std::max(expected, 1.0);
        ++freedom;
      }
    }
    freedom -= f.fit.freedom;
    out.volume_fraction += model.volume.dot(f.fit.density);
    add_entries(out, own, model, c, f);
    r.fits.push_back(f.fit);
  }
  out.goodness_of_fit = chi2 / std::max(freedom, 1.0);
  if (bed == Bed::Loose && !o.relative && !(options.area_fraction > 0)) hold_to_loose_fraction(r);
  if (o.relative)
    make_relative(r);
  else
    make_room(r);
  r.observations = std::move(o);
  return r;
}

}  // namespace

KMatrix kmatrix_of(const KMatrix& k, Types types, std::size_t cls) {
  KMatrix own = k;
  if (types == Types::ByClass) {
    for (std::size_t s = 0; s < own.shapes.size(); ++s) own.shapes[s].probability = s == cls;
    return own;
  }
  double all = 0;
  for (auto& e : own.shapes) {
    if (e.cls >= 0 && e.cls != static_cast<int>(cls)) e.probability = 0;
    all += e.probability;
  }
  if (!(all > 0) && depends_on_class(k, types))
    throw Error("no-shape-of-class", fmt::format("no shape is for the particles of class {}", cls),
                "estimate shapes with class: each from the same profiles, or with class: any")
        .parameter("types");
  if (depends_on_class(k, types))
    for (auto& e : own.shapes) e.probability /= all;
  return own;
}

bool depends_on_class(const KMatrix& k, Types types) {
  return types == Types::ByClass ||
         std::any_of(k.shapes.begin(), k.shapes.end(), [](const auto& e) { return e.cls >= 0; });
}

int classes_for(std::size_t profiles) {
  return std::max<int>(2, 2 * std::cbrt(static_cast<double>(profiles)));
}

UnfoldResult unfold(const Profiles& profiles, const KMatrix& k, const UnfoldOptions& options,
                    const Work& work) {
  constexpr std::size_t kLeast = 3;
  const Bed bed = bed_of(profiles);
  double visible = options.smallest_visible;
  if (visible < 0) visible = visible_in(observe(profiles, options.border, 0, options.area_fraction), bed);
  const Observations o = observe(profiles, options.border, visible, options.area_fraction);
  if (o.used < kLeast)
    throw Error("too-few-profiles",
                fmt::format("a size distribution needs at least {} profiles; there are {}", kLeast, o.used),
                "use a larger photograph, or border: all");
  for (int classes = options.classes > 0 ? options.classes : std::min(k.classes, classes_for(o.used));;
       --classes) {
    UnfoldResult r = unfold_classes(o, classes, visible, k, options, bed, work);
    const bool finite = is_finite(r);
    if (finite && (o.relative || r.distribution.volume_fraction <= 1)) return r;
    if (!finite && options.classes == 0 && classes > 1) continue;  // fewer profiles determine fewer classes
    const std::string found =
        finite ? fmt::format(
                     "the particles found would fill {:.3g} times the volume: the condition number of {:.2g} "
                     "amplifies the counting errors",
                     r.distribution.volume_fraction, r.condition)
               : fmt::format("{} profiles do not determine the densities of {} classes", o.used, classes);
    throw Error("unstable", found,
                options.method == Method::Inverse ? "use fewer classes, or method: em"
                : classes > 1                     ? "use fewer classes"
                                                  : "use a larger photograph")
        .parameter("classes");
  }
}

}  // namespace terrazzo::unfolding
