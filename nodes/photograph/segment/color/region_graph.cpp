#include "nodes/photograph/segment/color/region_graph.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <tuple>

namespace terrazzo::segment {
namespace {

double cost_of(const Region& a, const Region& b, float length) {
  const double d2 = (a.color() - b.color()).squaredNorm();
  return a.area * b.area / (a.area + b.area) * d2 / length;
}

}  // namespace

RegionGraph::RegionGraph(const LabImage& image, const std::vector<std::int32_t>& labels,
                         const std::vector<float>& weights)
    : pixels_(labels) {
  const std::int32_t n = labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end());
  regions_.resize(n);
  parent_.resize(n);
  std::iota(parent_.begin(), parent_.end(), 0);
  for (auto& l : pixels_) --l;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    Region& r = regions_[pixels_[i]];
    r.area += 1;
    r.weight += weights[i];
    r.sum += weights[i] * image.pixels[i].cast<double>();
  }
  auto border = [&](std::size_t i, std::size_t j) {
    if (pixels_[i] == pixels_[j]) return;
    regions_[pixels_[i]].borders[pixels_[j]] += 1;
    regions_[pixels_[j]].borders[pixels_[i]] += 1;
  };
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (x + 1 < image.width) border(image.index(x, y), image.index(x + 1, y));
      if (y + 1 < image.height) border(image.index(x, y), image.index(x, y + 1));
    }
}

std::int32_t RegionGraph::root(std::int32_t i) const {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

void RegionGraph::merge(double scale, const Work& work) {
  using Entry = std::tuple<double, std::int32_t, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::int32_t a = 0; a < static_cast<std::int32_t>(regions_.size()); ++a) {
    if (root(a) != a) continue;
    for (const auto& [b, length] : regions_[a].borders)
      if (a < b) queue.emplace(cost_of(regions_[a], regions_[b], length), a, b);
  }
  for (std::size_t step = 0; !queue.empty(); ++step) {
    if (step % 1024 == 0) work.check();
    auto [cost, a, b] = queue.top();
    if (cost > scale) break;
    queue.pop();
    if (root(a) != a || root(b) != b) continue;
    const auto found = regions_[a].borders.find(b);
    if (found == regions_[a].borders.end()) continue;
    // Costs change with every merge, mostly upwards, so they are updated only when they reach the top of the
    // queue.
    const double now = cost_of(regions_[a], regions_[b], found->second);
    if (now > cost * (1 + 1e-9)) {
      queue.emplace(now, a, b);
      continue;
    }
    if (regions_[a].borders.size() < regions_[b].borders.size()) std::swap(a, b);
    Region& big = regions_[a];
    Region& small = regions_[b];
    big.area += small.area;
    big.weight += small.weight;
    big.sum += small.sum;
    big.borders.erase(b);
    small.borders.erase(a);
    parent_[b] = a;
    for (const auto& [c, length] : small.borders) {
      Region& other = regions_[c];
      const float joint = big.borders[c] += length;
      other.borders.erase(b);
      other.borders[a] = joint;
      queue.emplace(cost_of(big, other, joint), std::min(a, c), std::max(a, c));
    }
    small.borders.clear();
  }
}

void RegionGraph::isolate(std::int32_t label) {
  for (const auto& [other, length] : regions_[label - 1].borders) regions_[other].borders.erase(label - 1);
  regions_[label - 1].borders.clear();
}

std::vector<std::int32_t> RegionGraph::labels() const {
  std::vector<std::int32_t> number(regions_.size(), 0), out(pixels_.size());
  std::int32_t count = 0;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    auto& n = number[root(pixels_[i])];
    if (n == 0) n = ++count;
    out[i] = n;
  }
  return out;
}

std::vector<Region> RegionGraph::regions() const {
  std::vector<std::int32_t> number(regions_.size(), -1);
  std::vector<std::int32_t> order;
  for (const auto p : pixels_)
    if (auto& n = number[root(p)]; n < 0) {
      n = order.size();
      order.push_back(root(p));
    }
  std::vector<Region> out;
  for (const auto r : order) {
    Region copy = regions_[r];
    copy.borders.clear();
    for (const auto& [c, length] : regions_[r].borders) copy.borders[number[c]] = length;
    out.push_back(std::move(copy));
  }
  return out;
}

}  // namespace terrazzo::segment
