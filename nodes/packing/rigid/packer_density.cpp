#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/packing/rigid/packer.h"

namespace terrazzo::packing {
namespace {

constexpr double kTrial = 1;  // share of the steps that the trial may take, with far fewer particles
// A trial of few particles in few steps is less dense than the packing can become, most of all for cubes,
// which order slowly. A request slightly above the trial is tried as it is; one far above is refused.
constexpr double kNear = 0.05, kHopeless = 0.15;
// Share of the reached volume fraction that jams no more. Dropping is stricter, because every particle must
// keep its size.
constexpr double kBelow = 0.975, kBelowDrop = 0.96;
constexpr double kEasy = 0.15, kRaise = 1.04;  // share of the steps; growth of the particles

}  // namespace

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
  if (!reachable_.jammed) budget_.expected = 1.3 * reachable_.steps + 100;
  // A sample that takes longer than all particles may is as good as jammed.
  const bool hopeless = reachable_.jammed || reachable_.steps > options_.iterations;
  const double least = options_.on_jam == OnJam::Fail ? requested - kHopeless : options_.least / kBelow;
  if (hopeless && result_.reachable <= least)
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
  for (std::size_t i = 0; i < p.count(); ++i) {
    p.scale[i] *= factor;
    p.size[i] *= factor;
  }
  population_.fraction *= std::pow(factor, 3);
  goal_ *= factor;
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
    packing_.scale = population_.particles.scale;
    packing_.size = population_.particles.size;
    anneal_and_audit(1 / factor, 0.5 * options_.iterations, work);
    if (packing_.shrink * factor > 1 && audit_.worst == 0) continue;
    packing_ = before;
    population_ = population;
    audit_ = audited;
    goal_ = goal;
    return;
  }
}

}  // namespace terrazzo::packing
