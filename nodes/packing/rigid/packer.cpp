#include "nodes/packing/rigid/packer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/packing/rigid/contact/turn.h"
#include "nodes/packing/rigid/limits.h"
#include "nodes/packing/rigid/lying.h"
#include "nodes/packing/rigid/placement.h"
#include "nodes/packing/rigid/shrunk_start.h"
#include "nodes/packing/rigid/spatial_order.h"
#include "nodes/packing/rigid/statistics.h"

namespace terrazzo::packing {
namespace {

constexpr int kAuditRounds = 60;
constexpr double kReserve = 0.25;  // share of the steps that is left for corrections by the audit

void reorder_all(Particles& p, const std::vector<std::int32_t>& order) {
  reorder(p.shape, order);
  reorder(p.cls, order);
  reorder(p.scale, order);
  reorder(p.size, order);
  reorder(p.color, order);
  reorder(p.voids, order);
  reorder(p.position, order);
  reorder(p.orientation, order);
}

Population population_of(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                         const PopulationOptions& options, const Work& work) {
  if (start && start->count() > 0)
    if (auto population = regrown(populate(distribution, shapes, nullptr, options, work), *start))
      return std::move(*population);
  return populate(distribution, shapes, start, options, work);
}

}  // namespace

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

Particles placed(const Particles& requested, const Packing& packing) {
  Particles p = requested;
  p.position = packing.position;
  p.orientation = packing.orientation;
  for (std::size_t i = 0; i < p.count(); ++i) {
    p.scale[i] *= packing.shrink;
    p.size[i] *= packing.shrink;
  }
  return p;
}

Packer::Packer(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
               const PackOptions& options, const Work& work)
    : shapes_(shapes),
      options_(options),
      work_(work),
      auditor_(shapes),
      population_(population_of(distribution, shapes, start, options.population, work)) {}

void Packer::prepare() {
  std::vector<bool> needed(shapes_.shapes.size(), false);
  for (int s : population_.particles.shape) needed[s] = true;
  contact_shapes_.resize(shapes_.shapes.size());
  const Work work = work_.part(0, 0.05);
  for (std::size_t s = 0; s < needed.size(); ++s) {
    work.progress(static_cast<double>(s) / needed.size(), "distance field of " + shapes_.shapes[s].name);
    if (needed[s]) contact_shapes_[s] = make_contact_shape(shapes_.shapes[s].mesh, work.quiet());
  }
}

void Packer::place() {
  packing_ = packing_of(population_.particles);
  std::vector<double> radius(packing_.count());
  for (std::size_t i = 0; i < radius.size(); ++i)
    radius[i] =
        std::cbrt(0.75 / std::numbers::pi * shapes_.shapes[packing_.shape[i]].volume) * packing_.scale[i];
  place_at_random(packing_, population_.kept, radius, options_.population.seed, work_.quiet(),
                  options_.population.clusters);
  if (options_.lying) {
    lay_flat(packing_, shapes_, population_.kept, options_.long_axes, options_.population.seed);
    packing_.home = packing_.orientation;
  }
  if (packing_.count() < kCached) return;
  index_.resize(packing_.count());
  std::iota(index_.begin(), index_.end(), 0);
  sort(spatial_order(packing_.box, packing_.position));
}

// Reorders the particles while they are packed; run() restores the original order.
void Packer::sort(const std::vector<std::int32_t>& order) {
  reorder_all(population_.particles, order);
  reorder(population_.size_class, order);
  reorder(index_, order);
  reorder(packing_.position, order);
  reorder(packing_.orientation, order);
  if (!packing_.home.empty()) reorder(packing_.home, order);
  reorder(packing_.shape, order);
  reorder(packing_.scale, order);
  reorder(packing_.size, order);
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
    if (audit_.found.size() < fewest) {
      fewest = audit_.found.size();
      since = 0;
    } else
      ++since;
    // If there are many pairs, or removing overlaps causes others, contacts are missed everywhere. Unless
    // there are many, use the mean depth, because a wide margin for all pairs disturbs the whole packing.
    if (many || since >= 3) {
      double mean = 0;
      for (const auto& p : audit_.found) mean += p.relative / audit_.found.size();
      anneal_.extra.all += many ? 0.6 * audit_.worst : 0.3 * mean;
    }
  }
}

void Packer::fill_result() {
  result_.coordination = coordination_number(contact_shapes_, packing_, 0.01, work_.quiet());
  if (!index_.empty()) sort(original_order());
  result_.particles = placed(population_.particles, packing_);
  set_request(result_, population_);
  result_.steps = budget_.used;
  result_.max_penetration = audit_.worst;
  result_.shrink = goal_ * packing_.shrink;
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
  const double least = std::cbrt(std::min(options_.least / population_.fraction, 1.0));
  anneal_.enough = options_.on_jam == OnJam::Shrink ? std::max(0.998, least) : 1;
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
  for (int k = 0; options_.on_jam == OnJam::Shrink && audit_.worst > kTolerance && k < 12; ++k) {
    packing_.shrink *= 1 - (2 + k) * std::min(audit_.worst, 0.05);
    audit_ = auditor_(placed(population_.particles, packing_), anneal_.binder_gap, work_.quiet());
  }
  if (options_.on_jam == OnJam::Fail ? packing_.shrink < 1 : fraction() < options_.least)
    throw Error("jammed",
                fmt::format("{} particles jammed at a volume fraction of {:.3f}; {:.3f} was requested",
                            packing_.count(), fraction(), population_.requested_fraction),
                "lower the volume fraction, raise `iterations`, or set on_jam to shrink or drop");
  if (jammed && options_.on_jam == OnJam::Drop) drop(work_.part(0.95, 1));
  if (audit_.worst > kTolerance)
    throw Error(
        "overlap",
        fmt::format("the audit found a penetration of {:.2e} of a particle's size that could not be removed",
                    audit_.worst),
        "raise `iterations` or lower the volume fraction");

  fill_result();
  return std::move(result_);
}

}  // namespace terrazzo::packing
