#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/packing/rigid/packer.h"
#include "nodes/packing/rigid/statistics.h"

namespace terrazzo::packing {
namespace {

constexpr int kDrops = 8;  // largest number of times that particles are dropped

template <class T>
void keep_only(std::vector<T>& v, const std::vector<bool>& keep) {
  std::size_t to = 0;
  if (v.empty()) return;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (keep[i]) v[to++] = v[i];
  v.resize(to);
}

}  // namespace

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
  population_.kept -= (std::count(keep.begin(), keep.begin() + population_.kept, false));
  keep_only(p.shape, keep);
  keep_only(p.cls, keep);
  keep_only(p.scale, keep);
  keep_only(p.size, keep);
  keep_only(p.color, keep);
  keep_only(p.voids, keep);
  keep_only(population_.size_class, keep);
  keep_only(p.position, keep);
  keep_only(p.orientation, keep);
  keep_only(index_, keep);
  population_.fraction = volume_fraction(shapes_, p);
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
    packing_.shrink = 1;
    packing_.overlap = std::numeric_limits<double>::infinity();
    std::vector<double> strain = strain_of(contact_shapes_, packing_, anneal_, work_.quiet());
    for (const auto& p : audit_.found) {
      strain[p.a] += p.relative;
      strain[p.b] += p.relative;
    }
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

}  // namespace terrazzo::packing
