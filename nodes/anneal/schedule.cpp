#include "nodes/anneal/schedule.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace terrazzo::anneal {
namespace {

enum class Outcome { Free, Stalled, OutOfTime };

class Schedule {
 public:
  Schedule(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options,
           const Work& work)
      : packing_(packing),
        options_(options),
        work_(work),
        quiet_(work.quiet()),
        relax_(shapes, packing, options.binder_gap) {
    relax_.extra = options.extra;
    limit_ = options.iterations;
  }

  AnnealResult run();

 private:
  Packing& packing_;
  const AnnealOptions& options_;
  const Work& work_;
  Work quiet_;  // the loops within an iteration do not move the progress bar
  Relaxation relax_;
  std::uint64_t shakes_ = 0;
  int used_ = 0, limit_ = 0;  // iterations
  Overlap last_;
  Packing best_;  // places and size of the densest free state

  int left() const { return limit_ - used_; }
  void tell();
  Outcome relax(double tolerance, int most, double least_progress);
  void set(double shrink, bool fine, double surplus);
  void grow();
  bool free_by_shrinking(double down);
  bool compact();
  void save();
  void restore();
};

void Schedule::tell() {
  if (used_ % 8 != 0) return;
  const double f = static_cast<double>(used_) / limit_;
  char note[96];
  std::snprintf(note, sizeof note, "penetration %.4f, size %.3f", std::max(last_.worst, 0.0),
                packing_.shrink);
  work_.progress(f, note);
}

void Schedule::set(double shrink, bool fine, double surplus) {
  packing_.shrink = shrink;
  relax_.fine = fine;
  relax_.surplus = surplus;
  relax_.forget();
}

// Iterates until no overlap is deeper than `tolerance`, or the energy falls by less than `least_progress` in
// 40 steps.
Outcome Schedule::relax(double tolerance, int most, double least_progress) {
  double before = 1e300;
  int kicks = 0;
  for (int k = 0; k < most; ++k) {
    if (left() <= 0) return Outcome::OutOfTime;
    last_ = relax_.step(tolerance, quiet_);
    ++used_;
    tell();
    if (last_.worst <= tolerance) return Outcome::Free;
    if (k % 40 == 39) {
      if (last_.energy > before * (1 - least_progress)) {
        // A few bodies caught in each other, in a packing that is free elsewhere, come loose by a kick.
        if (relax_.fine == false || last_.pairs > 2 + packing_.count() / 100 || ++kicks > 8)
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

// Growth with overlaps of some percent allowed on the way. Ends at full size, or where the bodies jam.
void Schedule::grow() {
  double rate = 0.06;
  set(std::min(1.0, options_.start_shrink), false, 0.005);
  relax(0.03, 60, 0.05);
  while (packing_.shrink < 1 && left() > 0) {
    const int before = used_;
    set(std::min(1.0, packing_.shrink * (1 + rate)), false, 0.005);
    relax(0.03, 40, 0.05);
    if (used_ - before < 10) rate = std::min(0.1, rate * 1.5);
    if (used_ - before >= 40) rate = std::max(0.01, rate * 0.6);
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

// Shrinks by `down` and more each time until no overlap is left.
bool Schedule::free_by_shrinking(double down) {
  for (;;) {
    limit_ = std::max(limit_, used_ + 200);  // a free state comes first, whatever it costs
    set(packing_.shrink * (1 - down), true, 0.002 * packing_.shrink);
    if (relax(0, 150, 0.3) == Outcome::Free) return true;
    if (packing_.shrink < 0.05) return false;
    down = std::min(0.2, 1.3 * down);
  }
}

// From a jammed state: shrink until free, then shake and grow by small steps. A step that fails is taken back
// and halved.
bool Schedule::compact() {
  if (!free_by_shrinking(std::max(0.003, 0.5 * last_.worst))) return false;
  save();
  double up = 0.003, temperature = 0.01;
  while (best_.shrink < options_.enough && left() > 0) {
    relax_.shake(temperature, options_.seed, ++shakes_, -1, quiet_);
    const double gap = 1 - best_.shrink;
    const double step = std::min(up, gap);
    set(std::min(1.0, best_.shrink + step), true, std::clamp(0.2 * step, 1e-4, 0.002));
    if (relax(0, 300, 0.15) == Outcome::Free) {
      save();
      up *= 1.4;
    } else {
      restore();
      up *= 0.5;
      temperature = std::max(0.5 * temperature, 0.5 * up);
      if (up < 2e-4) break;
    }
  }
  restore();
  return true;
}

AnnealResult Schedule::run() {
  AnnealResult result;
  if (packing_.count() == 0) return result.free = true, result;
  if (options_.settle) {
    set(packing_.shrink, true, 0.0005);
    result.free = relax(0, 400, 0.1) == Outcome::Free || compact();
  } else {
    grow();
    if (packing_.shrink == 1) {
      set(1, true, 0.002);
      result.free = relax(0, 600, 0.1) == Outcome::Free;
    }
    if (!result.free) result.free = compact();
  }
  result.iterations = used_;
  result.overlap = last_;
  return result;
}

}  // namespace

AnnealResult pack(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options,
                  const Work& work) {
  return Schedule(shapes, packing, options, work).run();
}

std::vector<double> strain_of(const std::vector<ContactShape>& shapes, Packing& packing,
                              const AnnealOptions& options, const Work& work) {
  Relaxation relaxation(shapes, packing, options.binder_gap);
  relaxation.extra = options.extra;
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

}  // namespace terrazzo::anneal
