#include "runtime/clients/studio/paint/brush_queue.h"

#include <algorithm>
#include <utility>

#include "nodes/common/geometry/periodic.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/cooccurrence/texture_nib/region.h"
#include "runtime/work.h"

namespace terrazzo::studio {
namespace {

constexpr std::chrono::milliseconds kLook{20};  // between two looks at the cancel flag

}  // namespace

BrushQueue::BrushQueue(Painting& painting, const std::atomic<bool>* cancel)
    : painting_(painting),
      cancel_(cancel),
      shown_(painting.picture()),
      strokes_(painting.strokes()),
      thread_([this] { run(); }) {}

BrushQueue::~BrushQueue() {
  interrupted_ = true;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void BrushQueue::begin_stroke(double radius) {
  rethrow();
  painting_.check_nib(radius);
  add({Step::Begin, radius, {}, {}});
  open_ = first_ = true;
  radius_ = radius;
}

void BrushQueue::extend_stroke(const Vec2& point) {
  rethrow();
  if (!open_) throw Error("no-stroke", "no stroke has begun");
  check_stroke({{{point}}, radius_, false});
  auto pixels = capsule(shown_.width, shown_.height, first_ ? point : last_, point, radius_);
  first_ = false;
  last_ = point;
  add({Step::Point, 0, point, std::move(pixels)});
}

void BrushQueue::end_stroke() {
  rethrow();
  if (open_) add({Step::End, 0, {}, {}});
  open_ = false;
}

void BrushQueue::add(Step step) {
  {
    const std::lock_guard lock(mutex_);
    for (const auto p : step.pixels) shown_.pixels[p] = draft(p);
    touch(step.pixels);
    points_ += step.kind == Step::Point;
    steps_.push_back(std::move(step));
  }
  changed_.notify_all();
}

// Repeats the rectangle around the region.
Vec3f BrushQueue::draft(std::uint32_t pixel) const {
  const int width = around_.x1 - around_.x0, height = around_.y1 - around_.y0;
  const int x = static_cast<int>(pixel) % shown_.width, y = static_cast<int>(pixel) / shown_.width;
  return texture_[static_cast<std::size_t>(wrap_index(y - around_.y0, height)) * width +
                  wrap_index(x - around_.x0, width)];
}

void BrushQueue::touch(const std::vector<std::uint32_t>& pixels) {
  if (pixels.empty()) return;
  texture_nib::Rectangle& r = touched_;
  if (r.x1 <= r.x0) r = {shown_.width, shown_.height, 0, 0};
  for (const auto p : pixels) {
    const int x = static_cast<int>(p) % shown_.width, y = static_cast<int>(p) / shown_.width;
    r = {std::min(r.x0, x), std::min(r.y0, y), std::max(r.x1, x + 1), std::max(r.y1, y + 1)};
  }
}

void BrushQueue::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stop_ || !steps_.empty(); });
    if (stop_) return;
    const Step& step = steps_.front();  // stays: only this thread removes steps while it works
    working_ = true;
    lock.unlock();
    std::exception_ptr error;
    try {
      const Work work(cancel_, nullptr, &interrupted_);
      switch (step.kind) {
        case Step::Begin:
          painting_.begin_stroke(step.radius);
          break;
        case Step::Point:
          painting_.extend_stroke(step.point, work);
          break;
        case Step::End:
          painting_.end_stroke();
          break;
      }
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (error) {
      error_ = error;
      steps_.clear();
      points_ = 0;
    } else {
      for (const auto p : step.pixels) shown_.pixels[p] = painting_.picture().pixels[p];
      touch(step.pixels);
      points_ -= step.kind == Step::Point;
      strokes_ = painting_.strokes();
      steps_.pop_front();
    }
    working_ = false;
    changed_.notify_all();
  }
}

void BrushQueue::rethrow() {
  const std::lock_guard lock(mutex_);
  if (error_) {
    open_ = false;
    std::rethrow_exception(std::exchange(error_, nullptr));
  }
}

BrushQueue::Progress BrushQueue::wait(std::chrono::milliseconds budget) {
  Progress out;
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, budget, [&] { return steps_.empty() && !working_; });
    out = {std::exchange(touched_, {}), points_, strokes_};
  }
  rethrow();
  return out;
}

void BrushQueue::read(const std::function<void(const Image&)>& reader) const {
  const std::lock_guard lock(mutex_);
  reader(shown_);
}

void BrushQueue::settle(std::unique_lock<std::mutex>& lock) {
  const Work work(cancel_, nullptr);
  while (!changed_.wait_for(lock, kLook, [&] { return steps_.empty() && !working_; })) work.check();
}

void BrushQueue::refresh() {
  shown_ = painting_.picture();
  touched_ = {};
  strokes_ = painting_.strokes();
  const NibOptions* choice = painting_.choice();
  if (!choice) return;
  const auto region =
      texture_nib::pixels_of(texture_nib::region_mask(choice->region, shown_.width, shown_.height));
  around_ = {shown_.width, shown_.height, 0, 0};
  for (const auto p : region) {
    const int x = static_cast<int>(p) % shown_.width, y = static_cast<int>(p) / shown_.width;
    around_ = {std::min(around_.x0, x), std::min(around_.y0, y), std::max(around_.x1, x + 1),
               std::max(around_.y1, y + 1)};
  }
  const int width = around_.x1 - around_.x0;
  texture_.resize(static_cast<std::size_t>(width) * (around_.y1 - around_.y0));
  constexpr std::size_t kStep = 7919;  // far apart
  for (std::size_t i = 0; i < texture_.size(); ++i)
    texture_[i] = shown_.pixels[region[i * kStep % region.size()]];
  for (const auto p : region) {
    const int x = static_cast<int>(p) % shown_.width, y = static_cast<int>(p) / shown_.width;
    texture_[static_cast<std::size_t>(y - around_.y0) * width + (x - around_.x0)] = shown_.pixels[p];
  }
}

void BrushQueue::idle(const std::function<void()>& act) {
  rethrow();
  std::unique_lock lock(mutex_);
  settle(lock);
  act();
}

void BrushQueue::change(const std::function<void()>& act) {
  idle([&] {
    open_ = false;
    act();
    refresh();
  });
}

bool BrushQueue::undo() {
  std::unique_lock lock(mutex_);
  open_ = false;
  const Work work(cancel_, nullptr);
  const auto waiting = steps_.begin() + (working_ ? 1 : 0);
  auto begin = steps_.end();
  for (auto s = waiting; s != steps_.end(); ++s)
    if (s->kind == Step::Begin) begin = s;
  if (begin != steps_.end()) {
    points_ -= (std::count_if(begin, steps_.end(), [](const Step& s) { return s.kind == Step::Point; }));
    steps_.erase(begin, steps_.end());
    settle(lock);  // earlier strokes are painted
    refresh();
    return true;
  }
  interrupted_ = true;
  settle(lock);
  interrupted_ = false;
  error_ = nullptr;
  const bool any = painting_.drop_stroke(work) || painting_.undo(work);
  refresh();
  return any;
}

}  // namespace terrazzo::studio
