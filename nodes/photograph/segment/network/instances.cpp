#include "nodes/photograph/segment/network/instances.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "nodes/data/indices.h"
#include "nodes/photograph/segment/neighbors.h"

namespace terrazzo::segment {
namespace {

constexpr double kOverlap = 0.4;
constexpr double kWithin = 0.6;  // share of an instance that lies in a label
constexpr double kPart = 0.8;    // of the label's area: larger instances are versions of it

// The section while it is being filled. Label k belongs to places()[k - 1].
class Filling {
 public:
  struct Place {
    std::size_t from = 0;              // index of the instance
    std::vector<std::int32_t> pixels;  // empty: removed
  };

  Filling(const std::vector<Instance>& instances, int width, int height, double min_area)
      : instances_(instances), width_(width), height_(height), min_area_(min_area) {
    labels_.assign(pixels_in(width, height), 0);
    seen_.assign(labels_.size(), 0);
    placed_.assign(instances.size(), 0);
    given_up_.assign(labels_.size(), 0);
  }

  const std::vector<std::int32_t>& labels() const { return labels_; }
  const std::vector<Place>& places() const { return places_; }
  bool has(std::size_t k) const { return placed_[k]; }

  // Another version of an instance that gave way.
  bool was_given_up(std::size_t k) const {
    const auto& pixels = instances_[k].pixels;
    const auto shared = std::count_if(pixels.begin(), pixels.end(), [&](auto i) { return given_up_[i]; });
    return shared >= kWithin * pixels.size();
  }
  void give_up(const Place& p) {
    for (const auto i : p.pixels) given_up_[i] = 1;
  }

  // Places the free part of an instance if it is large enough.
  bool place(std::size_t k) {
    const Instance& in = instances_[k];
    if (placed_[k] || in.pixels.size() < min_area_) return false;
    rest_.clear();
    for (const auto i : in.pixels)
      if (labels_[i] == 0) rest_.push_back(i);
    if (rest_.size() < (1 - kOverlap) * in.pixels.size()) return false;
    Place p{k, largest_piece()};
    if (p.pixels.size() < min_area_) return false;
    put(std::move(p));
    return true;
  }
  Place remove(std::size_t place) {
    Place p = std::exchange(places_[place], {});
    for (const auto i : p.pixels) labels_[i] = 0;
    placed_[p.from] = 0;
    return p;
  }
  void put(Place p) {
    placed_[p.from] = 1;
    places_.push_back(std::move(p));
    for (const auto i : places_.back().pixels) labels_[i] = places_.size();
  }

 private:
  std::vector<std::int32_t> largest_piece() {
    for (const auto i : rest_) seen_[i] = 1;
    std::vector<std::int32_t> largest;
    for (const auto first : rest_) {
      if (!seen_[first]) continue;
      piece_.assign(1, first);
      seen_[first] = 0;
      for (std::size_t q = 0; q < piece_.size(); ++q)
        neighbors(piece_[q], width_, height_, [&](std::int32_t j) {
          if (seen_[j]) {
            seen_[j] = 0;
            piece_.push_back(j);
          }
        });
      if (piece_.size() > largest.size()) largest.swap(piece_);
    }
    return largest;
  }

  const std::vector<Instance>& instances_;
  int width_, height_;
  double min_area_;
  std::vector<std::int32_t> labels_, rest_, piece_;
  std::vector<std::uint8_t> seen_, placed_, given_up_;
  std::vector<Place> places_;
};

}  // namespace

std::vector<std::vector<std::size_t>> instances_within(const std::vector<std::int32_t>& labels,
                                                       std::size_t count,
                                                       const std::vector<Instance>& instances,
                                                       const std::vector<std::size_t>& order,
                                                       const Work& work) {
  std::vector<std::int64_t> areas(count + 1, 0);
  for (const auto label : labels) ++areas[label];
  std::vector<std::vector<std::size_t>> within(count);
  std::vector<std::int32_t> shared(count + 1, 0);
  for (const std::size_t k : order) {
    work.check();
    const auto& pixels = instances[k].pixels;
    std::int32_t most = 0;
    for (const auto i : pixels)
      if (const auto label = labels[i]; label > 0 && ++shared[label] > shared[most]) most = label;
    const double on_most = shared[most];
    for (const auto i : pixels) shared[labels[i]] = 0;
    if (most == 0) continue;
    const double size = pixels.size();
    if (on_most >= kWithin * size && size <= kPart * areas[most]) within[most - 1].push_back(k);
  }
  return within;
}

Accepted accept_instances(const std::vector<Instance>& instances, int width, int height, double min_area,
                          double min_score, double (*worth)(double score), const Work& work) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < instances.size(); ++k)
    if (instances[k].score >= min_score) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return instances[a].score > instances[b].score; });
  const auto gain = [&](std::size_t k) { return worth(instances[k].score) - worth(min_score); };
  Filling filling(instances, width, height, min_area);
  const auto fill = [&] {
    for (const std::size_t k : order) {
      work.check();
      if (!filling.was_given_up(k)) filling.place(k);
    }
  };
  fill();
  constexpr int kRounds = 4;  // what replaces an instance may be replaced in turn
  for (int round = 0; round < kRounds; ++round) {
    std::vector<std::size_t> free;
    std::copy_if(order.begin(), order.end(), std::back_inserter(free),
                 [&](std::size_t k) { return !filling.has(k); });
    const auto within = instances_within(filling.labels(), filling.places().size(), instances, free, work);
    bool changed = false;
    for (std::size_t p = 0; p < within.size(); ++p) {
      if (within[p].empty()) continue;
      work.check();
      const std::size_t first = filling.places().size();
      Filling::Place before = filling.remove(p);
      double sum = 0;
      for (const std::size_t k : within[p])
        if (filling.place(k)) sum += gain(k);
      const auto covered = std::count_if(before.pixels.begin(), before.pixels.end(),
                                         [&](auto i) { return filling.labels()[i] > 0; });
      const bool enough = covered >= instances[before.from].explained * before.pixels.size();
      if (enough && sum > gain(before.from)) {
        filling.give_up(before);
        changed = true;
        continue;
      }
      for (std::size_t q = first; q < filling.places().size(); ++q) filling.remove(q);
      filling.put(std::move(before));
    }
    if (!changed) break;
    fill();
  }

  std::vector<std::int32_t> number(filling.places().size() + 1, 0);
  std::vector<std::size_t> kept;
  for (std::size_t p = 0; p < filling.places().size(); ++p)
    if (!filling.places()[p].pixels.empty()) kept.push_back(p);
  std::stable_sort(kept.begin(), kept.end(), [&](std::size_t a, std::size_t b) {
    const std::size_t i = filling.places()[a].from, j = filling.places()[b].from;
    return instances[i].score != instances[j].score ? instances[i].score > instances[j].score : i < j;
  });
  Accepted out;
  for (const std::size_t p : kept) {
    const std::size_t k = filling.places()[p].from;
    out.scores.push_back(instances[k].score);
    out.from.push_back(k);
    number[p + 1] = out.scores.size();
  }
  for (const auto label : filling.labels()) out.labels.push_back(number[label]);
  return out;
}

}  // namespace terrazzo::segment
