#include "nodes/packing/packing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>
#include <numeric>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/packing/audit.h"
#include "nodes/packing/limits.h"
#include "nodes/packing/placement.h"
#include "nodes/packing/reachable.h"
#include "nodes/packing/schedule.h"
#include "nodes/packing/shrunk_start.h"
#include "nodes/packing/spatial_order.h"
#include "nodes/packing/statistics.h"
#include "nodes/packing/turn.h"

namespace terrazzo::packing {
namespace {

Packing packing_of(const Particles& p) {
  Packing packing;
  packing.box = p.box;
  packing.shape = p.shape;
  packing.scale = p.scale;
  packing.size = p.size;
  packing.position = p.position;
  packing.orientation = p.orientation;
  return packing;
}

// `requested` with the positions, orientations and shrink factor of `packing`.
Particles placed(const Particles& requested, const Packing& packing) {
  Particles p = requested;
  p.position = packing.position;
  p.orientation = packing.orientation;
  for (std::size_t i = 0; i < p.count(); ++i) p.scale[i] *= packing.shrink, p.size[i] *= packing.shrink;
  return p;
}

template <class T>
void keep_only(std::vector<T>& v, const std::vector<bool>& keep) {
  std::size_t to = 0;
  if (v.empty()) return;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (keep[i]) v[to++] = v[i];
  v.resize(to);
}

constexpr int kAuditRounds = 60;
constexpr double kSettle = 400;    // steps that are always allowed, also after an audit
constexpr double kReserve = 0.25;  // share of the steps that is left for corrections by the audit
constexpr double kTrial = 1;       // share of the steps that the trial may take, with far fewer particles
// A trial of few particles in few steps is less dense than the packing can become, most of all for cubes,
// which order slowly. A request slightly above the trial is tried as it is; one far above is refused.
constexpr double kNear = 0.05;
// Share of the reached volume fraction that jams no more. Dropping is stricter, because every particle must
// keep its size.
constexpr double kBelow = 0.975, kBelowDrop = 0.96;
constexpr double kEasy = 0.15, kRaise = 1.04;  // share of the steps; growth of the particles
constexpr int kDrops = 8;                      // largest number of times that particles are dropped

void reorder_all(Particles& p, const std::vector<std::int32_t>& order) {
  reorder(p.shape, order), reorder(p.cls, order), reorder(p.scale, order), reorder(p.size, order);
  reorder(p.color, order), reorder(p.voids, order);
  reorder(p.position, order), reorder(p.orientation, order);
}

Population population_of(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                         const PopulationOptions& options, const Work& work) {
  if (start && start->count() > 0)
    if (auto population = regrown(populate(distribution, shapes, nullptr, options, work), *start))
      return std::move(*population);
  return populate(distribution, shapes, start, options, work);
}

class Packer {
 public:
  Packer(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
         const PackOptions& options, const Work& work)
      : shapes_(shapes),
        options_(options),
        work_(work),
        auditor_(shapes),
        population_(population_of(distribution, shapes, start, options.population, work)) {}

  PackResult run();
  // After a cancellation: what was reached, or nothing if no particle was moved.
  std::optional<InterruptedPacking> reached();

 private:
  const Shapes& shapes_;
  const PackOptions& options_;
  const Work& work_;
  Auditor auditor_;
  Population population_;
  std::vector<ContactShape> contact_shapes_;
  Packing packing_;
  AnnealOptions anneal_;
  Budget budget_;
  Reachable reachable_;
  AnnealResult state_;
  AuditResult audit_;
  PackResult result_;
  double goal_ = 1;                  // all particles were scaled by this before they were placed
  std::vector<std::int32_t> index_;  // original index of each particle; empty if the order is unchanged
  InterruptedPacking before_;        // a free packing, from before an attempt that may end without one

  InterruptedPacking interrupted() const;
  void prepare();
  void estimate();
  void fit_to(double fraction);
  void scale_all(double factor);
  void raise(const Work& work);
  void leave_out(double volume);
  void leave_out_again();
  void remove(const std::vector<bool>& keep);
  void place();
  void sort(const std::vector<std::int32_t>& order);
  std::vector<std::int32_t> original_order() const;
  void anneal_and_audit(double start_shrink, double steps, const Work& work);
  void drop(const Work& work);
  void remove_overlapping();
  bool has_more_detail() const;
  double volume_of(std::size_t i) const {
    const Particles& p = population_.particles;
    return shapes_.shapes[p.shape[i]].volume * std::pow(p.scale[i], 3);
  }
  double fraction() const { return population_.fraction * std::pow(packing_.shrink, 3); }
};

void Packer::prepare() {
  std::vector<bool> needed(shapes_.shapes.size(), false);
  for (int s : population_.particles.shape) needed[s] = true;
  contact_shapes_.resize(shapes_.shapes.size());
  const Work work = work_.part(0, 0.05);
  for (std::size_t s = 0; s < needed.size(); ++s) {
    work.progress(static_cast<double>(s) / static_cast<double>(needed.size()),
                  "distance field of " + shapes_.shapes[s].name);
    if (needed[s]) contact_shapes_[s] = make_contact_shape(shapes_.shapes[s].mesh, work.quiet());
  }
}

void Packer::place() {
  packing_ = packing_of(population_.particles);
  std::vector<double> radius(packing_.count());
  for (std::size_t i = 0; i < radius.size(); ++i)
    radius[i] =
        std::cbrt(0.75 / std::numbers::pi * shapes_.shapes[packing_.shape[i]].volume) * packing_.scale[i];
  place_at_random(packing_, population_.kept, radius, options_.population.seed, work_.quiet());
  if (packing_.count() < kCached) return;
  index_.resize(packing_.count());
  std::iota(index_.begin(), index_.end(), 0);
  sort(spatial_order(packing_.box, packing_.position));
}

// Reorders the particles while they are packed; run() restores the original order.
void Packer::sort(const std::vector<std::int32_t>& order) {
  reorder_all(population_.particles, order), reorder(population_.size_class, order);
  reorder(index_, order);
  reorder(packing_.position, order), reorder(packing_.orientation, order);
  reorder(packing_.shape, order), reorder(packing_.scale, order), reorder(packing_.size, order);
}

std::vector<std::int32_t> Packer::original_order() const {
  std::vector<std::int32_t> back(index_.size());
  std::iota(back.begin(), back.end(), 0);
  std::sort(back.begin(), back.end(), [&](std::int32_t a, std::int32_t b) { return index_[a] < index_[b]; });
  return back;
}

bool Packer::has_more_detail() const {
  return std::any_of(contact_shapes_.begin(), contact_shapes_.end(), [](const ContactShape& s) {
    return s.tree(ContactDetail::All).elements.size() > s.tree(ContactDetail::Fine).elements.size();
  });
}

// Tries a sample of the particles, and if it jams, asks for less than was requested.
void Packer::estimate() {
  const double requested = population_.fraction;
  const double easy = surely_reachable(population_, shapes_, contact_shapes_, options_.population.binder_gap);
  // A start that was shrunk needs the estimate again to know at which size the particles are to be packed.
  const bool regrows = population_.start_shrink < 1 && options_.on_jam == OnJam::Shrink;
  if (requested <= easy || (population_.kept == population_.particles.count() && !regrows)) return;
  const Work work = work_.part(0.05, 0.15);
  AnnealOptions trial = anneal_;
  trial.steps = kTrial * options_.iterations;
  reachable_ = try_sample(population_, shapes_, contact_shapes_, trial, work);
  if (!(reachable_.fraction > 0)) return;
  budget_.expected = 0.6 * options_.iterations;
  result_.reachable = std::max(easy, reachable_.fraction);
  if (!reachable_.jammed) {
    budget_.expected = 1.3 * reachable_.steps + 100;
    return;
  }
  if (options_.on_jam == OnJam::Fail && requested > result_.reachable + options_.hopeless)
    throw Error(
        "jammed",
        fmt::format("a sample of the particles jammed at a volume fraction of {:.3f}; {:.3f} was requested",
                    result_.reachable, population_.requested_fraction),
        "lower the volume fraction, or set on_jam to shrink or drop");
  if (options_.on_jam != OnJam::Fail && requested > result_.reachable + kNear)
    fit_to((options_.on_jam == OnJam::Drop ? kBelowDrop : kBelow) * result_.reachable);
}

// Shrinks all particles or leaves some out, to a volume fraction that can be packed.
void Packer::fit_to(double fraction) {
  if (population_.start_shrink < 1 && population_.kept == population_.particles.count())
    fraction = std::max(fraction, population_.fraction * std::pow(population_.start_shrink, 3));
  if (fraction >= population_.fraction) return;
  Particles& p = population_.particles;
  if (options_.on_jam == OnJam::Drop) {
    leave_out((population_.fraction - fraction) * p.box.prod());
    return;
  }
  scale_all(std::cbrt(fraction / population_.fraction));
}

void Packer::scale_all(double factor) {
  Particles& p = population_.particles;
  for (std::size_t i = 0; i < p.count(); ++i) p.scale[i] *= factor, p.size[i] *= factor;
  population_.fraction *= std::pow(factor, 3);
  goal_ *= factor;
}

InterruptedPacking Packer::interrupted() const {
  InterruptedPacking now{placed(population_.particles, packing_), packing_.overlap};
  if (index_.empty()) return now;
  reorder_all(now.particles, original_order());
  return now;
}

std::optional<InterruptedPacking> Packer::reached() {
  const auto density = [&](const InterruptedPacking& p) { return volume_fraction(shapes_, p.particles); };
  if (packing_.count() == 0 || !std::isfinite(packing_.overlap)) {
    if (before_.particles.count() == 0) return {};
    return std::move(before_);
  }
  InterruptedPacking now = interrupted();
  if (before_.particles.count() > 0 && (now.overlap > kTolerance || density(now) < density(before_)))
    return std::move(before_);
  return now;
}

// If the packing took few steps, the estimate was too low: aims higher, and keeps what was reached if that
// jams.
void Packer::raise(const Work& work) {
  while (goal_ < 1 && state_.free && audit_.worst == 0 && packing_.shrink == 1 &&
         budget_.used < kEasy * options_.iterations) {
    const Packing before = packing_;
    const Population population = population_;
    const AuditResult audited = audit_;
    const double goal = goal_, factor = std::min(kRaise, 1 / goal_);
    if (options_.interrupted) before_ = interrupted();
    scale_all(factor);
    packing_.scale = population_.particles.scale, packing_.size = population_.particles.size;
    anneal_and_audit(1 / factor, 0.5 * options_.iterations, work);
    if (packing_.shrink * factor > 1 && audit_.worst == 0) continue;
    packing_ = before, population_ = population, audit_ = audited, goal_ = goal;
    return;
  }
}

// Leaves out particles of about this volume, evenly over all sizes; those of `start` only if there are no
// others.
void Packer::leave_out(double volume) {
  const Particles& p = population_.particles;
  std::vector<bool> keep(p.count(), true);
  const auto thin = [&](std::size_t begin, std::size_t end) {
    double available = 0;
    for (std::size_t i = begin; i < end; ++i) available += volume_of(i);
    const double share = available > 0 ? std::min(1.0, volume / available) : 0;
    double due = 0.5;
    for (std::size_t i = begin; i < end; ++i) {
      due += share;
      if (due < 1) continue;
      due -= 1;
      keep[i] = false;
      volume -= volume_of(i);
    }
  };
  thin(population_.kept, p.count());
  if (volume > 0.01 * p.box.prod()) thin(0, population_.kept);
  remove(keep);
}

// Leaves out the particles that the interrupted packing had left out.
void Packer::leave_out_again() {
  std::vector<bool> keep(population_.particles.count(), false);
  std::fill_n(keep.begin(), population_.kept, true);
  remove(keep);
}

// Removes particles from the population before or after they are placed.
void Packer::remove(const std::vector<bool>& keep) {
  Particles& p = population_.particles;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) continue;
    ++result_.dropped;
    result_.dropped_volume += volume_of(i);
  }
  population_.kept -= static_cast<std::size_t>(
      std::count(keep.begin(), keep.begin() + static_cast<std::ptrdiff_t>(population_.kept), false));
  keep_only(p.shape, keep), keep_only(p.cls, keep), keep_only(p.scale, keep), keep_only(p.size, keep);
  keep_only(p.color, keep), keep_only(p.voids, keep), keep_only(population_.size_class, keep);
  keep_only(p.position, keep), keep_only(p.orientation, keep), keep_only(index_, keep);
  population_.fraction = volume_fraction(shapes_, p);
}

// Anneals until the audit finds no overlap. Every overlap found widens the margins of its particles.
void Packer::anneal_and_audit(double start_shrink, double steps, const Work& work) {
  anneal_.start_shrink = start_shrink;
  anneal_.settle = false;
  double left = steps;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  int since = 0;  // rounds without fewer pairs
  for (int round = 0; round < kAuditRounds && since < 12; ++round) {
    anneal_.steps = std::max(left, kSettle);
    state_ = pack(contact_shapes_, packing_, anneal_, budget_, work);
    anneal_.resume = false;
    left -= state_.steps;
    result_.iterations += state_.iterations;
    turn_spheres(shapes_, contact_shapes_, packing_, anneal_.binder_gap, anneal_.seed, work_.quiet());
    audit_ = auditor_(placed(population_.particles, packing_), anneal_.binder_gap, work_.quiet());
    packing_.overlap = std::max(packing_.overlap, audit_.worst);
    budget_.used += Budget::steps(audit_.tests, packing_.count());
    if (audit_.worst == 0 || !state_.free || budget_.left() <= 0) break;
    const bool many = audit_.found.size() > 8 + audit_.pairs / 40;
    anneal_.settle = true;
    anneal_.local = audit_.found.size() * 20 <= packing_.count();
    if (many && anneal_.detail == ContactDetail::Fine && has_more_detail()) {
      anneal_.detail = ContactDetail::All;  // use full detail before widening margins
      continue;
    }
    for (const auto& p : audit_.found) {  // a margin that was insufficient is doubled
      double& margin = anneal_.extra.of_pair[{p.a, p.b}];
      margin += std::max(margin, 1.5 * p.depth + 5e-4 * std::min(packing_.size[p.a], packing_.size[p.b]));
    }
    if (audit_.found.size() < fewest)
      fewest = audit_.found.size(), since = 0;
    else
      ++since;
    // If there are many pairs, or removing overlaps causes others, contacts are missed everywhere. Unless
    // there are many, use the mean depth, because a wide margin for all pairs disturbs the whole packing.
    if (many || since >= 3) {
      double mean = 0;
      for (const auto& p : audit_.found) mean += p.relative / static_cast<double>(audit_.found.size());
      anneal_.extra.all += many ? 0.6 * audit_.worst : 0.3 * mean;
    }
  }
}

// Removes the most strained particles, more each time, until the others are free.
void Packer::drop(const Work& work) {
  const auto few = [&] { return packing_.shrink == 1 && audit_.found.size() * 100 <= packing_.count(); };
  const auto jammed = [&] { return packing_.shrink < 1 || audit_.worst > kTolerance; };
  for (int k = 0; k < kDrops && packing_.count() > 0 && jammed() && !few(); ++k) {
    if (options_.interrupted && (packing_.overlap <= kTolerance || before_.particles.count() == 0))
      before_ = interrupted();
    // Some of the volume that the particles lost when they shrank; all of it is more than necessary, because
    // the most strained ones leave.
    const double excess = std::max(0.005, (0.5 + 0.1 * k) * (1 - std::pow(packing_.shrink, 3))) *
                          population_.fraction * packing_.box.prod();
    packing_.shrink = 1, packing_.overlap = std::numeric_limits<double>::infinity();
    std::vector<double> strain = strain_of(contact_shapes_, packing_, anneal_, work_.quiet());
    for (const auto& p : audit_.found) strain[p.a] += p.relative, strain[p.b] += p.relative;
    std::vector<std::size_t> order(strain.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return strain[a] > strain[b]; });
    std::vector<bool> keep(packing_.count(), true);
    double removed = 0;
    for (std::size_t at = 0; at < order.size() && removed < excess; ++at) {
      keep[order[at]] = false;
      removed += volume_of(order[at]);
    }
    population_.particles.position = packing_.position;
    population_.particles.orientation = packing_.orientation;
    remove(keep);
    packing_ = packing_of(population_.particles);
    anneal_.extra.of_pair.clear();  // its indices have changed
    budget_.limit = budget_.used + kSettle + options_.iterations / 20.0;
    anneal_and_audit(1, kSettle, work);
  }
  if (packing_.shrink == 1 && audit_.worst > kTolerance) remove_overlapping();
}

// Removes one particle of each pair in which the audit found a penetration.
void Packer::remove_overlapping() {
  std::vector<bool> keep(packing_.count(), true);
  for (const auto& p : audit_.found)
    if (p.relative > kTolerance && keep[p.a] && keep[p.b])
      keep[volume_of(p.a) < volume_of(p.b) ? p.a : p.b] = false;
  population_.particles.position = packing_.position;
  population_.particles.orientation = packing_.orientation;
  remove(keep);
  packing_ = packing_of(population_.particles);
  audit_ = auditor_(placed(population_.particles, packing_), anneal_.binder_gap, work_.quiet());
}

PackResult Packer::run() {
  // Particles that may shrink or be left out can have any density, unless gaps alone fill the box.
  const double gap = options_.population.binder_gap;
  if (options_.on_jam == OnJam::Fail || gap > 0) refuse_impossible_density(population_, shapes_, gap);
  refuse_what_memory_cannot_hold(population_, shapes_);
  prepare();
  anneal_.binder_gap = options_.population.binder_gap;
  anneal_.seed = options_.population.seed;
  // If shrinking is allowed, the last 0.2 % of size are not worth most of the time.
  anneal_.enough = options_.on_jam == OnJam::Shrink ? 0.998 : 1;
  for (const auto& s : contact_shapes_)
    if (s.field.kind() == DistanceField::Kind::Grid) anneal_.aim = 1.002;
  budget_.expected = 0.1 * options_.iterations;
  budget_.limit = (1 + kReserve) * options_.iterations;
  if (population_.start_shrink < 1 && options_.on_jam == OnJam::Drop) leave_out_again();
  estimate();
  place();
  const bool resumed = population_.kept == packing_.count();
  anneal_.resume = resumed && population_.start_shrink < 1;
  const double begin = reachable_.fraction > 0 ? 0.15 : 0.05;
  anneal_and_audit(resumed ? std::min(1.0, population_.start_shrink / goal_) : 0.6, options_.iterations,
                   work_.part(begin, 0.95));

  if (options_.on_jam == OnJam::Shrink) raise(work_.part(0.95, 1));
  const bool jammed = packing_.shrink < 1 || audit_.worst > kTolerance;
  if (packing_.shrink < 1 && options_.on_jam == OnJam::Fail) {
    throw Error("jammed",
                fmt::format("{} particles jammed at a volume fraction of {:.3f}; {:.3f} was requested",
                            packing_.count(), fraction(), population_.requested_fraction),
                "lower the volume fraction, raise `iterations`, or set on_jam to shrink or drop");
  }
  for (int k = 0; options_.on_jam == OnJam::Shrink && audit_.worst > kTolerance && k < 12; ++k) {
    packing_.shrink *= 1 - (2 + k) * std::min(audit_.worst, 0.05);
    audit_ = auditor_(placed(population_.particles, packing_), anneal_.binder_gap, work_.quiet());
  }
  if (jammed && options_.on_jam == OnJam::Drop) drop(work_.part(0.95, 1));
  if (audit_.worst > kTolerance)
    throw Error(
        "overlap",
        fmt::format("the audit found a penetration of {:.2e} of a particle's size that could not be removed",
                    audit_.worst),
        "raise `iterations` or lower the volume fraction");

  result_.coordination = coordination_number(contact_shapes_, packing_, 0.01, work_.quiet());
  if (!index_.empty()) {
    sort(original_order());
  }
  result_.particles = placed(population_.particles, packing_);
  result_.size_class = population_.size_class;
  result_.expected = population_.expected;
  result_.requested_fraction = population_.requested_fraction;
  result_.steps = budget_.used;
  result_.max_penetration = audit_.worst;
  result_.shrink = goal_ * packing_.shrink;
  result_.kept = population_.kept;
  result_.notes = population_.notes;
  if (result_.shrink < 1)
    result_.notes.push_back(
        fmt::format("the particles jammed: all were shrunk to {:.4f} of their size, which reduces the volume "
                    "fraction to {:.3f}; {:.3f} was requested",
                    result_.shrink, fraction(), result_.requested_fraction));
  if (result_.dropped > 0)
    result_.notes.push_back(
        fmt::format("the particles jammed: {} were removed, which reduces the volume fraction to {:.3f}; "
                    "{:.3f} was requested",
                    result_.dropped, fraction(), result_.requested_fraction));
  return std::move(result_);
}

}  // namespace

PackResult pack_particles(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                          const PackOptions& options, const Work& work) {
  Packer packer(distribution, shapes, start, options, work);
  try {
    return packer.run();
  } catch (const Cancelled&) {
    try {
      if (options.interrupted)
        if (const auto reached = packer.reached()) options.interrupted(*reached);
    } catch (const std::bad_alloc&) {  // without memory for a copy, the packing is canceled all the same
    }
    throw;
  }
}

}  // namespace terrazzo::packing
