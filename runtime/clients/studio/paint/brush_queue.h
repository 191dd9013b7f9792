// Paints strokes on a thread of its own, so that a page gets an answer in every frame however large the nib
// is (Malzbender and Spach 1993, section 4.2, paint as much as fits into a time step). What is painted
// depends on the points alone and not on the time that they take.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "nodes/cooccurrence/texture_nib/nib.h"
#include "nodes/data/image.h"
#include "runtime/clients/studio/paint/painting.h"

namespace terrazzo::studio {

// All methods are for one thread, other than its own. Those that queue a step rethrow what an earlier step
// threw; the steps after that one are dropped.
class BrushQueue {
 public:
  // Nothing else may use `painting` until the queue is destroyed, except in idle() and change().
  BrushQueue(Painting& painting, const std::atomic<bool>* cancel);
  ~BrushQueue();

  // Queue a step and return at once. Pixels of a point show a draft, unarranged texture of the nib's region,
  // until the point is painted. Throw what the methods of Painting throw.
  void begin_stroke(double radius);
  void extend_stroke(const Vec2& point);
  void end_stroke();

  struct Progress {
    texture_nib::Rectangle changed;  // by steps since the last call
    std::size_t points = 0;          // number of points that are not painted yet
    std::size_t strokes = 0;         // painted
  };
  // Waits until all steps are done, but not longer than `budget`.
  Progress wait(std::chrono::milliseconds budget);

  // Calls `reader` with what is painted so far, and drafts.
  void read(const std::function<void(const Image&)>& reader) const;

  // Call `act` after all steps are done. change(): it chooses another nib.
  void idle(const std::function<void()>& act);
  void change(const std::function<void()>& act);
  // Undoes the last stroke, or the last nib if it has no strokes. Drops what is queued of the stroke and
  // interrupts it if it is in work. False if there is nothing to undo.
  bool undo();

 private:
  struct Step {
    enum Kind { Begin, Point, End } kind;
    double radius = 0;
    Vec2 point = Vec2::Zero();
    std::vector<std::uint32_t> pixels;  // that the point covers
  };
  void run();
  void add(Step);
  void rethrow();
  void settle(std::unique_lock<std::mutex>&);  // waits until the thread is idle
  void refresh();
  Vec3f draft(std::uint32_t pixel) const;
  void touch(const std::vector<std::uint32_t>& pixels);

  Painting& painting_;
  const std::atomic<bool>* cancel_;
  std::atomic<bool> interrupted_{false};

  // Of the caller's thread.
  bool open_ = false, first_ = true;
  double radius_ = 0;
  Vec2 last_ = Vec2::Zero();
  texture_nib::Rectangle around_;  // the rectangle around the nib's region
  std::vector<Vec3f> texture_;     // its colors; where the region is not, colors from elsewhere in it

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<Step> steps_;  // the first one may be in work
  bool working_ = false, stop_ = false;
  std::exception_ptr error_;
  Image shown_;
  texture_nib::Rectangle touched_;
  std::size_t points_ = 0, strokes_ = 0;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace terrazzo::studio
