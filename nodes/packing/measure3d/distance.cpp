#include "nodes/packing/measure3d/distance.h"

#include <algorithm>
#include <array>
#include <limits>

#include "nodes/packing/measure3d/lines.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

// Lower envelope of the parabolas f + w(p − q)², added by increasing q.
class Envelope {
 public:
  explicit Envelope(double w) : w_(w) {}

  void clear() { parabolas_.clear(); }

  void add(int q, double f) {
    if (f == kFar) return;
    double from = -std::numeric_limits<double>::infinity();
    while (!parabolas_.empty()) {
      const Parabola& last = parabolas_.back();
      from = (f - last.f + w_ * (static_cast<double>(q) * q - static_cast<double>(last.q) * last.q)) /
             (2 * w_ * (q - last.q));
      if (from > last.from) break;
      parabolas_.pop_back();
      from = -std::numeric_limits<double>::infinity();
    }
    parabolas_.push_back({q, f, from});
  }

  // Calls set(p, value) for begin ≤ p < end.
  template <class Set>
  void read(int begin, int end, Set&& set) const {
    if (parabolas_.empty()) return;
    std::size_t k = 0;
    for (int p = begin; p < end; ++p) {
      while (k + 1 < parabolas_.size() && parabolas_[k + 1].from < p) ++k;
      const double d = p - parabolas_[k].q;
      set(p, static_cast<float>(parabolas_[k].f + w_ * d * d));
    }
  }

 private:
  struct Parabola {
    int q;
    double f, from;  // the lowest one from this position on
  };
  double w_;
  std::vector<Parabola> parabolas_;
};

// Adds the distance along one axis to the squared distances along the axes before it. Within a run of one
// class, the nearest other voxel is in a line of the run or is one of the two voxels at its ends: what is
// beyond these is farther.
class LineTransform {
 public:
  LineTransform(std::size_t n, double w, bool periodic)
      : n_(n), periodic_(periodic), of_(n), f_(n), out_(n), envelope_(w) {}

  // To be set before run(), and then changed.
  std::uint8_t& of(std::size_t i) { return of_[i]; }
  float& value(std::size_t i) { return out_[i]; }

  void run() {
    f_ = out_;
    int first = 0;  // where a run begins
    if (periodic_) {
      while (first < n_ && of_[first] == of_[first > 0 ? first - 1 : n_ - 1]) ++first;
      if (first == n_) return run_endless();
    }
    const auto at = [&](int i) { return first + i < n_ ? first + i : first + i - n_; };
    for (int i = 0; i < n_;) {
      const int begin = i, k = of_[at(i)];
      envelope_.clear();
      if (periodic_ || begin > 0) envelope_.add(begin - 1, 0);
      for (; i < n_ && of_[at(i)] == k; ++i) envelope_.add(i, f_[at(i)]);
      if (periodic_ || i < n_) envelope_.add(i, 0);
      envelope_.read(begin, i, [&](int p, float v) { out_[at(p)] = v; });
    }
  }

 private:
  int n_;
  bool periodic_;
  std::vector<std::uint8_t> of_;
  std::vector<float> f_, out_;
  Envelope envelope_;

  // A line that wraps and has one class. The nearest image of a voxel is at most half a period away.
  void run_endless() {
    envelope_.clear();
    for (int q = -(n_ / 2); q < n_ + n_ / 2; ++q) envelope_.add(q, f_[(q + n_) % n_]);
    envelope_.read(0, n_, [&](int p, float v) { out_[p] = v; });
  }
};

}  // namespace

std::vector<float> squared_distances(const Classes& classes, std::uint64_t memory, const Work& work) {
  // Lines next to each other are copied together, because those along y and z share lines of the cache.
  constexpr std::size_t kLanes = 16, kGrain = 64;
  require_memory(4.0 * classes.of.size(), memory, "the distances to the surface");
  std::vector<float> out(classes.of.size(), kFar);
  const Vec3 w = squared_edges(classes.box.spacing);
  for (int axis = 0; axis < 3; ++axis) {
    const VoxelLines lines(classes.box.size, axis);
    const std::size_t blocks = (lines.count + kLanes - 1) / kLanes;
    work.part(axis / 3.0, (axis + 1) / 3.0).parallel(blocks, kGrain, [&](std::size_t b, std::size_t e) {
      std::vector<LineTransform> lane(kLanes, LineTransform(lines.n, w[axis], classes.box.periodic));
      for (std::size_t block = b; block < e; ++block) {
        const std::size_t first = block * kLanes, count = std::min(kLanes, lines.count - first);
        const auto visit = [&](auto&& copy) {
          std::array<std::size_t, kLanes> start;
          for (std::size_t l = 0; l < count; ++l) start[l] = lines.start(first + l);
          for (std::size_t i = 0; i < lines.n; ++i)
            for (std::size_t l = 0; l < count; ++l) copy(lane[l], i, start[l] + i * lines.stride);
        };
        visit([&](LineTransform& line, std::size_t i, std::size_t at) {
          line.of(i) = classes.of[at];
          line.value(i) = out[at];
        });
        for (std::size_t l = 0; l < count; ++l) lane[l].run();
        visit([&](LineTransform& line, std::size_t i, std::size_t at) { out[at] = line.value(i); });
      }
    });
  }
  return out;
}

}  // namespace terrazzo::measure3d
