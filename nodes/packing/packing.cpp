#include "nodes/packing/packing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/packing/audit.h"
#include "nodes/packing/limits.h"
#include "nodes/packing/placement.h"
#include "nodes/packing/schedule.h"
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

void reorder_all(Particles& p, const std::vector<std::int32_t>& order) {
  reorder(p.shape, order), reorder(p.cls, order), reorder(p.scale, order), reorder(p.size, order);
  reorder(p.color, order), reorder(p.voids, order);
  reorder(p.position, order), reorder(p.orientation, order);
}

class Packer {
 public:
  Packer(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
         const PackOptions& options, const Work& work)
      : shapes_(shapes),
        options_(options),
        work_(work),
        auditor_(shapes),
        population_(populate(distribution, shapes, start, options.population, work)) {}

  PackResult run();

 private:
  const Shapes& shapes_;
  const PackOptions& options_;
  const Work& work_;
  Auditor auditor_;
  Population population_;
  std::vector<ContactShape> contact_shapes_;
  Packing packing_;
  AnnealOptions anneal_;
  AnnealResult state_;
  AuditResult audit_;
  PackResult result_;
  std::vector<std::int32_t> index_;  // original index of each particle; empty if the order is unchanged

  void prepare();
  void place();
  void sort(const std::vector<std::int32_t>& order);
  void anneal_and_audit(double start_shrink, const Work& work);
  void drop(const Work& work);
  bool has_more_detail() const;
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

bool Packer::has_more_detail() const {
  return std::any_of(contact_shapes_.begin(), contact_shapes_.end(), [](const ContactShape& s) {
    return s.tree(Detail::All).elements.size() > s.tree(Detail::Fine).elements.size();
  });
}

// Anneals until the audit finds no overlap. Every overlap found widens the margins of its particles.
void Packer::anneal_and_audit(double start_shrink, const Work& work) {
  anneal_.start_shrink = start_shrink;
  anneal_.settle = false;
  anneal_.detail = Detail::Fine;
  anneal_.extra = {};
  const int all = options_.iterations;
  int left = all;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  int since = 0;  // rounds without fewer pairs
  for (int round = 0; round < kAuditRounds && since < 12; ++round) {
    anneal_.iterations = std::max(left, 400);
    state_ = pack(contact_shapes_, packing_, anneal_, work);
    result_.iterations += state_.iterations;
    left -= state_.iterations;
    turn_spheres(shapes_, contact_shapes_, packing_, anneal_.binder_gap, anneal_.seed, work_.quiet());
    audit_ = auditor_(placed(population_.particles, packing_), anneal_.binder_gap, work_.quiet());
    if (audit_.worst == 0 || !state_.free) break;
    const bool many = audit_.found.size() > 8 + audit_.pairs / 40;
    anneal_.settle = true;
    if (many && anneal_.detail == Detail::Fine && has_more_detail()) {
      anneal_.detail = Detail::All;  // use full detail before widening margins
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

// Removes the most strained particles, a few at a time, until the others are free.
void Packer::drop(const Work& work) {
  while (packing_.count() > 0 && (packing_.shrink < 1 || audit_.worst > kTolerance)) {
    packing_.shrink = 1;
    std::vector<double> strain = strain_of(contact_shapes_, packing_, anneal_, work_.quiet());
    for (const auto& p : audit_.found) strain[p.a] += p.relative, strain[p.b] += p.relative;
    std::vector<std::size_t> order(strain.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return strain[a] > strain[b]; });
    std::size_t strained = 0;
    for (double s : strain) strained += s > 0;
    const std::size_t most = std::max<std::size_t>(1, std::min(strained / 12, packing_.count() / 50));
    std::vector<bool> keep(packing_.count(), true);
    for (std::size_t k = 0; k < most; ++k) {
      const std::size_t i = order[k];
      keep[i] = false;
      ++result_.dropped;
      result_.dropped_volume += shapes_.shapes[packing_.shape[i]].volume * std::pow(packing_.scale[i], 3);
    }
    Particles& p = population_.particles;
    keep_only(p.shape, keep), keep_only(p.cls, keep), keep_only(p.scale, keep), keep_only(p.size, keep);
    keep_only(p.color, keep), keep_only(p.voids, keep), keep_only(population_.size_class, keep),
        keep_only(index_, keep);
    keep_only(packing_.position, keep), keep_only(packing_.orientation, keep);
    p.position = packing_.position, p.orientation = packing_.orientation;
    population_.fraction = volume_fraction(shapes_, p);
    packing_ = packing_of(p);
    anneal_and_audit(1, work);
  }
}

PackResult Packer::run() {
  refuse_what_cannot_be(population_, shapes_, options_.population.binder_gap);
  prepare();
  place();
  anneal_.binder_gap = options_.population.binder_gap;
  anneal_.seed = options_.population.seed;
  // If shrinking is allowed, the last 0.2 % of size are not worth most of the time.
  anneal_.enough = options_.on_jam == OnJam::Shrink ? 0.998 : 1;
  for (const auto& s : contact_shapes_)
    if (s.field.kind() == DistanceField::Kind::Grid) anneal_.aim = 1.002;
  const bool resumed = population_.kept == packing_.count();
  anneal_and_audit(resumed ? 1.0 : 0.6, work_.part(0.05, 0.95));

  const bool jammed = packing_.shrink < 1 || audit_.worst > kTolerance;
  if (packing_.shrink < 1 && options_.on_jam == OnJam::Fail) {
    throw Error("jammed",
                fmt::format("{} particles jammed at a volume fraction of {:.3f}; {:.3f} was requested",
                            packing_.count(), fraction(), population_.requested_fraction),
                "lower the volume fraction, raise `iterations`, or set on_jam to shrink or drop");
  }
  for (int k = 0; options_.on_jam == OnJam::Shrink && audit_.worst > kTolerance && k < 40; ++k) {
    packing_.shrink *= 1 - 2 * std::min(audit_.worst, 0.05);
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
    std::vector<std::int32_t> back(index_.size());
    std::iota(back.begin(), back.end(), 0);
    std::sort(back.begin(), back.end(),
              [&](std::int32_t a, std::int32_t b) { return index_[a] < index_[b]; });
    sort(back);
  }
  result_.particles = placed(population_.particles, packing_);
  result_.size_class = population_.size_class;
  result_.expected = population_.expected;
  result_.requested_fraction = population_.requested_fraction;
  result_.max_penetration = audit_.worst;
  result_.shrink = packing_.shrink;
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
  return Packer(distribution, shapes, start, options, work).run();
}

}  // namespace terrazzo::packing
