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
    parent_.push_back(parent_.size());
    summit_.push_back(summit);
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
    contacts[kept].erase(gone);
    contacts[gone].erase(kept);
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

bool is_particle(const NetworkMaps& m, std::int32_t i) {
  return !(m.inside[i] <= kInside || m.not_material[i] > 0.5f);
}

// Floods the relief from the summits down; within a level, pixels next to a basin first.
class Flood {
 public:
  explicit Flood(const NetworkMaps& m)
      : m_(m),
        relief_(m.inside.size(), 0.0f),
        basin_(m.inside.size(), -1),
        queued_(m.inside.size(), 0),
        queue_(kLevels + 1) {}

  void run(const Work& work) {
    std::vector<std::vector<std::int32_t>> level(kLevels + 1);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(relief_.size()); ++i) {
      if (!is_particle(m_, i)) continue;
      relief_[i] = relief_at(m_, i);
      level[level_of(i)].push_back(i);
    }
    for (int now = kLevels; now >= 0; --now) {
      if (now % 64 == 0) work.check();
      drain(now);
      for (const auto i : level[now]) {
        if (basin_[i] >= 0 || queued_[i]) continue;
        basin_[i] = basins_.add(relief_[i]);
        queue_neighbors(i, now);
        drain(now);
      }
    }
  }

  const std::vector<std::int32_t>& basin() const { return basin_; }  // of each pixel, or −1
  Basins& basins() { return basins_; }

 private:
  int level_of(std::int32_t i) const { return std::clamp<int>(relief_[i] * kLevels, 0, kLevels); }

  void queue_neighbors(std::int32_t i, int now) {
    neighbors(i, m_.width, m_.height, [&](std::int32_t j) {
      if (basin_[j] >= 0 || queued_[j] || !is_particle(m_, j)) return;
      queued_[j] = 1;
      queue_[std::min(now, level_of(j))].push_back(j);
    });
  }

  // Floods the queue of a level.
  void drain(int now) {
    for (std::size_t q = 0; q < queue_[now].size(); ++q) {
      const std::int32_t i = queue_[now][q];
      basin_[i] = join(i, std::min(relief_[i], static_cast<float>(now + 1) / kLevels));
      queue_neighbors(i, now);
    }
    queue_[now].clear();
  }

  // Joins the basins around a pixel that are low, and returns the one that it belongs to.
  std::int32_t join(std::int32_t i, float height) {
    std::int32_t mine = -1;
    neighbors(i, m_.width, m_.height, [&](std::int32_t j) {
      if (basin_[j] < 0) return;
      const std::int32_t other = basins_.root(basin_[j]);
      if (mine < 0) {
        mine = other;
      } else if (mine != other) {
        const std::int32_t low = basins_.summit(mine) < basins_.summit(other) ? mine : other;
        if (basins_.summit(low) - height < kDynamics) {
          basins_.merge(mine, other);
          mine = basins_.root(mine);
        } else if (relief_[j] > height && basins_.summit(other) > basins_.summit(mine)) {
          mine = other;
        }
      }
    });
    return mine;
  }

  const NetworkMaps& m_;
  std::vector<float> relief_;
  Basins basins_;
  std::vector<std::int32_t> basin_;
  std::vector<std::uint8_t> queued_;
  std::vector<std::vector<std::int32_t>> queue_;
};

}  // namespace

std::vector<std::int32_t> find_basins(const NetworkMaps& m, const Work& work) {
  Flood flood(m);
  flood.run(work);
  const std::vector<std::int32_t>& basin = flood.basin();
  Basins& basins = flood.basins();
  merge_open_neighbors(m, basin, basins);
  std::vector<std::int32_t> labels(basin.size(), 0), number(basins.size(), 0);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < basin.size(); ++i) {
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
