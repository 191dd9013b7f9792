// The steps of pack_particles(), by subject: packer.cpp places and anneals, packer_density.cpp chooses the
// volume fraction to aim at, packer_removal.cpp leaves out particles.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "nodes/packing/rigid/audit.h"
#include "nodes/packing/rigid/packing.h"
#include "nodes/packing/rigid/reachable.h"
#include "nodes/packing/rigid/schedule.h"

namespace terrazzo::packing {

constexpr double kSettle = 400;  // steps that are always allowed, also after an audit

Packing packing_of(const Particles&);

// `requested` with the positions, orientations and shrink factor of `packing`.
Particles placed(const Particles& requested, const Packing& packing);

// One call of pack_particles().
class Packer {
 public:
  Packer(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
         const PackOptions& options, const Work& work);

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

  void prepare();
  void place();
  void sort(const std::vector<std::int32_t>& order);
  std::vector<std::int32_t> original_order() const;
  bool has_more_detail() const;
  void anneal_and_audit(double start_shrink, double steps, const Work& work);
  InterruptedPacking interrupted() const;

  void estimate();
  void fit_to(double fraction);
  void scale_all(double factor);
  void raise(const Work& work);

  void leave_out(double volume);
  void leave_out_again();
  void remove(const std::vector<bool>& keep);
  void drop(const Work& work);
  void remove_overlapping();
  void fill_result();

  double volume_of(std::size_t i) const {
    const Particles& p = population_.particles;
    return shapes_.shapes[p.shape[i]].volume * std::pow(p.scale[i], 3);
  }
  double fraction() const { return population_.fraction * std::pow(packing_.shrink, 3); }
};

}  // namespace terrazzo::packing
