#include "nodes/packing/rigid/schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"

namespace terrazzo::packing {
namespace {

constexpr double kHot = 0.9;    // step length that agitates the bodies
constexpr int kAgitated = 150;  // number of iterations with it
constexpr double kRate = 0.02;  // rate of shrinking, in mean overlaps per iteration
constexpr double kGain = 3e-4;  // growth in kPatience rounds below which the bodies are considered jammed
constexpr int kPatience = 5;
constexpr double kRounding = 1e-5;  // overlap of a free state after its sizes were scaled back and forth
constexpr double kGrowth = 0.2;     // share of the steps for growth: crowded thin shapes take many tests

enum class Outcome { Free, Stalled, OutOfTime };

class Schedule {
 public:
  Schedule(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options,
           Budget& budget, const Work& work)
      : packing_(packing),
        options_(options),
        budget_(budget),
        work_(work),
        quiet_(work.quiet()),
        relax_(shapes, packing, options.binder_gap) {
    relax_.extra = options.extra;
    most_ = limit_ = std::max(1.0, std::min(options.steps, budget.left()));
  }

  AnnealResult run();
  void leave_best();

 private:
  Packing& packing_;
  const AnnealOptions& options_;
  Budget& budget_;
  const Work& work_;
  Work quiet_;  // without progress reports, for the loops within an iteration
  Relaxation relax_;
  std::uint64_t shakes_ = 0;
  int iterations_ = 0;
  double used_ = 0, limit_ = 0, most_ = 0;  // steps; limit_ grows if a free state needs more than `most_`
  Overlap last_;
  Packing best_;  // positions and size of the densest free state

  double left() const { return limit_ - used_; }
  void iterate(double enough);
  Outcome relax(double tolerance, int most, double least_progress);
  void set(double shrink, bool fine, double surplus);
  void grow();
  bool free_by_shrinking(double down);
  bool decompress();
  bool compact(double over, double step);
  void resume();
  void save();
  void restore();
};

void Schedule::iterate(double enough) {
  last_ = relax_.step(enough, quiet_);
  const double steps = std::max(1.0, Budget::steps(last_.tests, packing_.count()));
  used_ += steps;
  budget_.used += steps;
  if (++iterations_ % 8 != 0) return;
  work_.progress(budget_.progress(),
                 fmt::format("penetration {:.4f}, size {:.3f}", std::max(last_.worst, 0.0), packing_.shrink));
}

void Schedule::set(double shrink, bool fine, double surplus) {
  const ContactDetail detail = fine ? options_.detail : ContactDetail::Coarse;
  if (relax_.detail != detail || relax_.surplus != surplus) relax_.forget();
  relax_.resize(shrink);
  relax_.detail = detail;
  relax_.surplus = surplus;
}

// Iterates until no overlap is deeper than `tolerance`, or the energy falls by a share of less than
// `least_progress` in 40 steps.
Outcome Schedule::relax(double tolerance, int most, double least_progress) {
  double before = 1e300;
  int kicks = 0;
  for (int k = 0; k < most; ++k) {
    if (left() <= 0) return Outcome::OutOfTime;
    iterate(tolerance);
    if (last_.worst <= tolerance) return Outcome::Free;
    if (k % 40 == 39) {
      if (last_.energy > before * (1 - least_progress)) {
        // In a packing that is otherwise free, a random kick can release a few interlocked bodies.
        if (relax_.detail == ContactDetail::Coarse || last_.pairs > 2 + packing_.count() / 100 || ++kicks > 8)
          return Outcome::Stalled;
        relax_.shake(0.01 * kicks, options_.seed, ++shakes_, std::max(relax_.surplus, 0.5 * last_.worst),
                     quiet_);
        before = 1e300;
        continue;
      }
      before = last_.energy;
    }
  }
  return Outcome::Stalled;
}

// Grows the bodies while allowing overlaps of some percent. Ends at full size, or when the bodies jam.
void Schedule::grow() {
  double rate = 0.06;
  set(std::min(1.0, options_.start_shrink), false, 0.005);
  relax(0.03, 60, 0.05);
  while (packing_.shrink < options_.aim && left() > 0 && used_ < std::max(kGrowth * limit_, 400.0)) {
    const int before = iterations_;
    set(std::min(options_.aim, packing_.shrink * (1 + rate)), false, 0.005);
    relax(0.03, 40, 0.05);
    if (iterations_ - before < 10) rate = std::min(0.1, rate * 1.5);
    if (iterations_ - before >= 40) rate = std::max(0.01, rate * 0.6);
    if (last_.worst > 0.15) return;
  }
  relax(0.005, 200, 0.2);
}

void Schedule::save() {
  best_.shrink = packing_.shrink;
  best_.position = packing_.position;
  best_.orientation = packing_.orientation;
}

void Schedule::restore() {
  packing_.shrink = best_.shrink;
  packing_.position = best_.position;
  packing_.orientation = best_.orientation;
  relax_.rest();
}

// Shrinks by `down`, and by more each time, until no overlap remains.
bool Schedule::free_by_shrinking(double down) {
  for (;;) {
    // A free state is needed at any cost.
    if (best_.position.empty() && !options_.overlaps) limit_ = std::max(limit_, used_ + 200);
    set(packing_.shrink * (1 - down), true, 0.002 * packing_.shrink);
    if (relax(0, 150, 0.3) == Outcome::Free) return true;
    if (packing_.shrink < 0.05) return false;
    down = std::min(0.2, 1.3 * down);
  }
}

// Overlapping bodies shrink at a rate proportional to their overlap while they continue to separate, so that
// they become free just at their jamming density. Returns false if time runs out.
bool Schedule::decompress() {
  for (;;) {
    // The first free state may cost half as much again, because nothing else can be returned.
    if (left() <= 0 && (options_.overlaps || !best_.position.empty())) return false;
    iterate(0);
    if (last_.worst <= 0 || left() <= -0.5 * most_) break;
    const double mean = std::sqrt(last_.energy / static_cast<double>(std::max<std::size_t>(last_.pairs, 1)));
    if (last_.worst < 1e-4 || mean < 2e-5) break;
    const double before = packing_.shrink;
    const double after = before * (1 - std::min(kRate * mean, 0.01));
    relax_.resize(after);
    for (const double goal : {options_.aim, 1.0})  // the target sizes are worth a longer try
      if (before > goal && after <= goal) {
        relax_.resize(goal);
        if (relax(0, 400, 0.1) == Outcome::Free) return true;
        break;
      }
  }
  return last_.worst <= 0 || free_by_shrinking(std::max(1e-4, 0.5 * last_.worst));
}

// Repeatedly presses jammed bodies into each other, agitated by steps that are too long, and lets them
// decompress to their jamming density. Each round finds a denser state, until `enough` is reached or rounds
// stop gaining. `over` is the share of the size by which the bodies are pressed.
bool Schedule::compact(double over, double step) {
  bool any = false;
  std::vector<double> reached;
  for (;;) {
    set(any ? packing_.shrink * (1 + over) : packing_.shrink, true, 2e-4);
    relax_.step_length = step;
    relax(0, kAgitated, -1);
    relax_.step_length = Relaxation::kCold;
    if (!decompress()) break;
    if (best_.position.empty() || packing_.shrink > best_.shrink) save();
    any = true;
    reached.push_back(best_.shrink);
    if (best_.shrink >= options_.enough || left() <= 0) break;
    if (reached.size() > kPatience && reached.back() < reached[reached.size() - 1 - kPatience] * (1 + kGain))
      break;
  }
  if (best_.position.empty()) return false;
  restore();
  return true;
}

// Keeps the state at the beginning as a first free state if it is one.
void Schedule::resume() {
  set(std::min(1.0, options_.start_shrink), true, 0);
  last_ = relax_.measure(quiet_);
  if (last_.worst <= kRounding) save();
}

// After a cancellation. Bodies may be anywhere in the middle of an iteration, but each is whole.
void Schedule::leave_best() {
  if (!best_.position.empty()) {
    restore();
    packing_.overlap = 0;
  } else {
    relax_.rest();
    if (iterations_ > 0) packing_.overlap = std::max(0.0, last_.worst);
  }
  packing_.shrink = std::min(packing_.shrink, 1.0);
}

AnnealResult Schedule::run() {
  AnnealResult result;
  if (packing_.count() == 0) {
    result.free = true;
    return result;
  }
  if (options_.resume && !options_.settle) resume();
  if (options_.settle) {
    set(packing_.shrink, true, 0.0005);
    relax_.local = options_.local;
    result.free = relax(0, 400, 0.1) == Outcome::Free;
    relax_.local = false;
    result.free =
        result.free || (packing_.shrink < options_.enough ? decompress() : compact(0.01, Relaxation::kCold));
  } else {
    grow();
    if (packing_.shrink == options_.aim) {
      set(options_.aim, true, 0.002);
      result.free = relax(0, 600, 0.1) == Outcome::Free;
    }
    if (!result.free) result.free = compact(relax_.spheres() ? 0.1 : 0.05, kHot);
  }
  if (packing_.shrink > 1) packing_.shrink = 1;
  packing_.overlap = result.free ? 0 : std::max(0.0, last_.worst);
  result.iterations = iterations_;
  result.steps = used_;
  result.overlap = last_;
  return result;
}

}  // namespace

AnnealResult pack(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options,
                  Budget& budget, const Work& work) {
  Schedule schedule(shapes, packing, options, budget, work);
  try {
    return schedule.run();
  } catch (const Cancelled&) {
    schedule.leave_best();
    throw;
  }
}

std::vector<double> strain_of(const std::vector<ContactShape>& shapes, Packing& packing,
                              const AnnealOptions& options, const Work& work) {
  Relaxation relaxation(shapes, packing, options.binder_gap);
  relaxation.extra = options.extra;
  relaxation.detail = options.detail;
  relaxation.surplus = 0;
  relaxation.measure(work);
  return relaxation.strain();
}

double coordination_number(const std::vector<ContactShape>& shapes, Packing& packing, double within,
                           const Work& work) {
  if (packing.count() == 0) return 0;
  Relaxation relaxation(shapes, packing, 0);
  relaxation.surplus = within;
  return 2.0 * static_cast<double>(relaxation.measure(work).touching) / static_cast<double>(packing.count());
}

}  // namespace terrazzo::packing
