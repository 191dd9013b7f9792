#include "nodes/anneal/schedule.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace terrazzo::anneal {
namespace {

enum class Outcome { Free, Stalled, OutOfTime };

class Schedule {
 public:
  Schedule(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options, const Work& work)
      : packing_(packing), options_(options), work_(work), quiet_(work.quiet()), relax_(shapes, packing, options.binder_gap) {
    if (!options.extra.empty()) relax_.extra = options.extra;
  }

  AnnealResult run();

 private:
  Packing& packing_;
  const AnnealOptions& options_;
  const Work& work_;
  Work quiet_;  // the loops within an iteration do not move the progress bar
  Relaxation relax_;
  int used_ = 0;
  Overlap last_;

  int left() const { return options_.iterations - used_; }
  void tell();
  Outcome relax(double tolerance, int most, double least_progress);
  void set(double shrink, bool fine, double surplus);
  bool grow();
  void compact();
};

void Schedule::tell() {
  if (used_ % 8 != 0) return;
  const double f = static_cast<double>(used_) / options_.iterations;
  char note[96];
  std::snprintf(note, sizeof note, "penetration %.4f, size %.3f", std::max(last_.worst, 0.0), packing_.shrink);
  work_.progress(f, note);
}

void Schedule::set(double shrink, bool fine, double surplus) {
  packing_.shrink = shrink;
  relax_.fine = fine;
  relax_.surplus = surplus;
  relax_.forget();
}

// Iterates until no overlap is deeper than `tolerance`, or the energy falls by less than `least_progress` in 40 steps.
Outcome Schedule::relax(double tolerance, int most, double least_progress) {
  double before = 1e300;
  for (int k = 0; k < most; ++k) {
    if (left() <= 0) return Outcome::OutOfTime;
    last_ = relax_.step(quiet_);
    ++used_;
    tell();
    if (last_.worst <= tolerance) return Outcome::Free;
    if (k % 40 == 39) {
      if (last_.energy > before * (1 - least_progress)) return Outcome::Stalled;
      before = last_.energy;
    }
  }
  return Outcome::Stalled;
}

// Coarse growth, overlaps of some percent allowed on the way.
bool Schedule::grow() {
  double rate = 0.06;
  set(std::min(1.0, options_.start_shrink), false, 0.005);
  relax(0.03, 60, 0.05);
  while (packing_.shrink < 1 && left() > 0) {
    const int before = used_;
    set(std::min(1.0, packing_.shrink * (1 + rate)), false, 0.005);
    relax(0.03, 40, 0.05);
    if (used_ - before < 10) rate = std::min(0.1, rate * 1.5);
    if (used_ - before >= 40) rate = std::max(0.01, rate * 0.6);
  }
  return relax(0.005, 200, 0.2) == Outcome::Free;
}

AnnealResult Schedule::run() {
  AnnealResult result;
  if (packing_.count() == 0) return result.free = true, result;
  grow();
  set(1, true, 0.002);
  Outcome o = relax(0, 600, 0.1);
  result.free = o == Outcome::Free;
  result.iterations = used_;
  result.overlap = last_;
  return result;
}

}  // namespace

AnnealResult pack(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options,
                  const Work& work) {
  return Schedule(shapes, packing, options, work).run();
}

}  // namespace terrazzo::anneal
