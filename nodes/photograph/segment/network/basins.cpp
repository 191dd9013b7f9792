#include "nodes/photograph/segment/network/basins.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <tuple>

#include "nodes/photograph/segment/neighbors.h"
#include "nodes/photograph/segment/network/majority.h"

namespace terrazzo::segment {
namespace {

constexpr float kDynamics = 0.12f, kSummit = 0.2f, kInside = 0.4f, kOpenBorder = 0.3f;
constexpr int kLevels = 1024;

float relief_at(const NetworkMaps& m, std::int32_t i) {
  return m.distance[i] * m.inside[i] * (1 - 0.5f * m.border[i]);
}

// Basins that merge.
class Basins {
 public:
  std::int32_t add(float summit) {
    parent_.push_back(static_cast<std::int32_t>(parent_.size())), summit_.push_back(summit);
    return parent_.back();
  }
  std::int32_t root(std::int32_t k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }
  float summit(std::int32_t root) const { return summit_[root]; }
  void merge(std::int32_t a, std::int32_t b) {
    if (summit_[a] < summit_[b] || (summit_[a] == summit_[b] && b < a)) std::swap(a, b);
    parent_[b] = a;
  }
  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::int32_t> parent_;
  std::vector<float> summit_;
};

struct SharedBorder {
  double border = 0;  // sum of the map of borders
  std::int64_t length = 0;
  double mean() const { return border / length; }
};

// Merges the two neighbors with the faintest common border, as long as its mean is below the limit. Their
// borders to others add up, so that no chain of faint spots joins what is separated elsewhere.
void merge_open_neighbors(const NetworkMaps& m, const std::vector<std::int32_t>& basin, Basins& basins) {
  std::vector<std::map<std::int32_t, SharedBorder>> contacts(basins.size());
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(basin.size()); ++i) {
    if (basin[i] < 0) continue;
    const auto meet = [&](std::int32_t j) {
      if (basin[j] < 0) return;
      const std::int32_t a = basins.root(basin[i]), b = basins.root(basin[j]);
      if (a == b) return;
      for (SharedBorder* c : {&contacts[a][b], &contacts[b][a]}) {
        c->border += std::max(m.border[i], m.border[j]);
        ++c->length;
      }
    };
    if (i % m.width + 1 < m.width) meet(i + 1);
    if (i / m.width + 1 < m.height) meet(i + m.width);
  }
  struct Pair {
    double mean;
    std::int32_t a, b;
    bool operator>(const Pair& o) const { return std::tie(mean, a, b) > std::tie(o.mean, o.a, o.b); }
  };
  std::priority_queue<Pair, std::vector<Pair>, std::greater<>> faintest;
  const auto consider = [&](std::int32_t a, std::int32_t b) {
    if (const double mean = contacts[a][b].mean(); mean < kOpenBorder)
      faintest.push({mean, std::min(a, b), std::max(a, b)});
  };
  for (std::int32_t a = 0; a < static_cast<std::int32_t>(contacts.size()); ++a)
    for (const auto& [b, c] : contacts[a])
      if (a < b) consider(a, b);
  while (!faintest.empty()) {
    const Pair p = faintest.top();
    faintest.pop();
    const auto it = contacts[p.a].find(p.b);
    if (it == contacts[p.a].end() || it->second.mean() != p.mean) continue;  // merged or changed since
    basins.merge(p.a, p.b);
    const std::int32_t kept = basins.root(p.a), gone = kept == p.a ? p.b : p.a;
    contacts[kept].erase(gone), contacts[gone].erase(kept);
    const auto moved = std::move(contacts[gone]);
    contacts[gone].clear();
    for (const auto& [other, c] : moved) {
      contacts[other].erase(gone);
      for (SharedBorder* to : {&contacts[kept][other], &contacts[other][kept]}) {
        to->border += c.border;
        to->length += c.length;
      }
    }
    for (const auto& [other, c] : contacts[kept]) consider(kept, other);
  }
}

}  // namespace

std::vector<std::int32_t> find_basins(const NetworkMaps& m, const Work& work) {
  const std::int32_t n = m.inside.size();
  std::vector<float> relief(n, 0.0f);
  std::vector<std::vector<std::int32_t>> level(kLevels + 1);
  for (std::int32_t i = 0; i < n; ++i) {
    if (m.inside[i] <= kInside || m.not_material[i] > 0.5f) continue;
    relief[i] = relief_at(m, i);
    level[std::clamp(static_cast<int>(relief[i] * kLevels), 0, kLevels)].push_back(i);
  }
  // Flood from the summits down; within a level, pixels next to a basin first.
  Basins basins;
  std::vector<std::int32_t> basin(n, -1);
  std::vector<std::uint8_t> queued(n, 0);
  std::vector<std::vector<std::int32_t>> queue(kLevels + 1);
  const auto level_of = [&](std::int32_t i) {
    return std::clamp(static_cast<int>(relief[i] * kLevels), 0, kLevels);
  };
  const auto flooded = [&](std::int32_t i, int now) {
    neighbors(i, m.width, m.height, [&](std::int32_t j) {
      if (basin[j] >= 0 || queued[j] || m.inside[j] <= kInside || m.not_material[j] > 0.5f) return;
      queued[j] = 1;
      queue[std::min(now, level_of(j))].push_back(j);
    });
  };
  for (int now = kLevels; now >= 0; --now) {
    if (now % 64 == 0) work.check();
    const auto drain = [&] {
      for (std::size_t q = 0; q < queue[now].size(); ++q) {
        const std::int32_t i = queue[now][q];
        const float height = std::min(relief[i], static_cast<float>(now + 1) / kLevels);
        std::int32_t mine = -1;
        neighbors(i, m.width, m.height, [&](std::int32_t j) {
          if (basin[j] < 0) return;
          const std::int32_t other = basins.root(basin[j]);
          if (mine < 0) {
            mine = other;
          } else if (mine != other) {
            const std::int32_t low = basins.summit(mine) < basins.summit(other) ? mine : other;
            if (basins.summit(low) - height < kDynamics) {
              basins.merge(mine, other);
              mine = basins.root(mine);
            } else if (relief[j] > height && basins.summit(other) > basins.summit(mine)) {
              mine = other;
            }
          }
        });
        basin[i] = mine;
        flooded(i, now);
      }
      queue[now].clear();
    };
    drain();
    for (const auto i : level[now]) {
      if (basin[i] >= 0 || queued[i]) continue;
      basin[i] = basins.add(relief[i]);
      flooded(i, now);
      drain();
    }
  }
  merge_open_neighbors(m, basin, basins);
  std::vector<std::int32_t> labels(n, 0), number(basins.size(), 0);
  std::int32_t count = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    if (basin[i] < 0) continue;
    const std::int32_t root = basins.root(basin[i]);
    if (basins.summit(root) < kSummit) continue;
    if (number[root] == 0) number[root] = ++count;
    labels[i] = number[root];
  }
  for (int round = 0; round < 2; ++round) labels = majority(labels, m.width, m.height, 1, work);
  return labels;
}

}  // namespace terrazzo::segment
