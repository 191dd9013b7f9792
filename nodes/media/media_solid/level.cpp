#include "nodes/media/media_solid/level.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::media_solid {
namespace {

constexpr std::size_t kBatch = 4096;  // voxels that decide on the same counts

// Bit k tells whether byte k is not 0; bytes are below 128.
std::uint64_t not_zero(std::uint64_t bytes) {
  return (((bytes + 0x7f7f7f7f7f7f7f7full) >> 7 & 0x0101010101010101ull) * 0x0102040810204080ull) >> 56;
}

// Of the pattern whose lower left pixel lies `corner` = 5·row + column into the 5 × 5 pixels.
int pattern_at(std::uint32_t bits, int corner) {
  return (bits >> corner & 7) | (bits >> (corner + 5) & 7) << 3 | (bits >> (corner + 10) & 7) << 6;
}

constexpr int kCorners[9] = {0, 1, 2, 5, 6, 7, 10, 11, 12};
// The voxel in the middle is the last pixel of the first pattern, and the first of the last.
constexpr int kMiddle[9] = {256, 128, 64, 32, 16, 8, 4, 2, 1};

}  // namespace

void Level::PatternCounts::change(int pattern, std::int64_t by) {
  const std::int64_t e = excess[pattern] += by;
  const float w = weight[pattern];
  step[pattern] = {w * static_cast<float>(1 - 2 * e), w * static_cast<float>(1 + 2 * e)};
}

Level::Level(std::vector<std::uint8_t> field, const Vec3i& size, int phases,
             const std::vector<PatternTarget>& targets, double floor, const Work& work)
    : field_(std::move(field)),
      size_(size),
      step_{1, static_cast<std::uint32_t>(size.x()), static_cast<std::uint32_t>(size.x()) * size.y()},
      phases_(phases),
      counted_(phases == 2 ? 1 : phases),
      first_(phases == 2 ? 1 : 0) {
  const double voxels = field_.size();
  int widest = 0;
  for (const PatternTarget& t : targets) {
    groups_.push_back({t.axis == 0 ? 1 : 0, t.axis == 2 ? 1 : 2, t.spacing, 3 * (t.spacing - 1)});
    widest = std::max(widest, t.spacing);
    for (int p = 0; p < counted_; ++p) {
      PatternCounts& table = tables_.emplace_back();
      for (int k = 0; k < kPatterns; ++k) {
        const double expected = t.phase[first_ + p][k] * voxels;
        table.excess[k] = -std::llround(expected);
        table.weight[k] = static_cast<float>(1 / (expected + floor * voxels));
      }
    }
  }
  reach_.resize(3 * static_cast<std::size_t>(widest));
  for (const Group& g : groups_)
    for (const int axis : {g.columns, g.rows}) {
      auto& reach = reach_[g.reach + axis];
      reach.resize(static_cast<std::size_t>(kSpan) * size_[axis]);
      for (int i = 0; i < size_[axis]; ++i)
        for (int k = 0; k < kSpan; ++k) {
          const int at = (i + (k - 2) * g.spacing) % size_[axis];
          reach[static_cast<std::size_t>(kSpan) * i + k] = (at < 0 ? at + size_[axis] : at) * step_[axis];
        }
    }
  count_all(work);
}

Vec3i Level::place(std::uint32_t voxel) const {
  const int row = voxel / step_[1];
  return {static_cast<int>(voxel % step_[1]), row % size_.y(), row / size_.y()};
}

void Level::gather(std::uint32_t voxel, std::vector<Around>& around) const {
  const Vec3i at = place(voxel);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const std::uint32_t* columns = &reach_[group.reach + group.columns][kSpan * at[group.columns]];
    const std::uint32_t* rows = &reach_[group.reach + group.rows][kSpan * at[group.rows]];
    const std::uint8_t* slice =
        &field_[voxel - at[group.columns] * step_[group.columns] - at[group.rows] * step_[group.rows]];
    // Local copies, since writing bytes could change what a pointer shows.
    std::array<std::uint32_t, kSpan> across, up;
    std::copy_n(columns, kSpan, across.begin());
    std::copy_n(rows, kSpan, up.begin());
    Around pixels{};
    for (int j = 0; j < kSpan; ++j)
      for (int i = 0; i < kSpan; ++i) pixels[kSpan * j + i] = slice[up[j] + across[i]];
    around[g] = pixels;
  }
}

std::uint32_t Level::bits(const Around& around, int phase) const {
  std::uint32_t out = 0;
  const std::uint64_t all = 0x0101010101010101ull * phase;
  for (int word = 0; word < 4; ++word) {
    std::uint64_t bytes;
    std::memcpy(&bytes, &around[8 * word], 8);
    out |= static_cast<std::uint32_t>(not_zero(bytes ^ all)) << (8 * word);
  }
  return ~out;
}

double Level::cost_of(const std::vector<Around>& around, int phase) const {
  double sum = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Step* step = tables_[g * counted_ + (phase - first_)].step.data();
    const std::uint32_t b = bits(around[g], phase);
    float part = 0;
    for (int k = 0; k < 9; ++k) {
      const int pattern = pattern_at(b, kCorners[k]);
      part += step[pattern].remove + step[pattern ^ kMiddle[k]].add;
    }
    sum += part;
  }
  return sum;
}

double Level::cost(const std::vector<Around>& around, int from, int to) const {
  return phases_ == 2 ? cost_of(around, 1) : cost_of(around, from) + cost_of(around, to);
}

void Level::apply(std::uint32_t voxel, const std::vector<Around>& around, int to) {
  const int from = field_[voxel];
  const auto flip = [&](int phase) {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      PatternCounts& table = tables_[g * counted_ + (phase - first_)];
      const std::uint32_t b = bits(around[g], phase);
      for (int k = 0; k < 9; ++k) {
        const int pattern = pattern_at(b, kCorners[k]);
        table.change(pattern, -1);
        table.change(pattern ^ kMiddle[k], 1);
      }
    }
  };
  if (phases_ == 2) {
    flip(1);
  } else {
    flip(from);
    flip(to);
  }
  field_[voxel] = to;
}

void Level::count_all(const Work& work) {
  using Counts = std::array<std::int64_t, kPatterns>;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const auto& columns = reach_[groups_[g].reach + groups_[g].columns];
    const auto& rows = reach_[groups_[g].reach + groups_[g].rows];
    for (int p = 0; p < counted_; ++p) {
      const int phase = first_ + p;
      const Counts counts = work.quiet().reduce(
          field_.size(), 1 << 16, Counts{},
          [&](std::size_t begin, std::size_t end) {
            Counts part{};
            for (std::size_t v = begin; v < end; ++v) {
              const Vec3i at = place(v);
              const int a = groups_[g].columns, b = groups_[g].rows;
              const std::uint8_t* slice = &field_[v - at[a] * step_[a] - at[b] * step_[b]];
              int pattern = 0;
              for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 3; ++i)
                  pattern |= (slice[rows[kSpan * at[b] + 2 + j] + columns[kSpan * at[a] + 2 + i]] == phase)
                             << (3 * j + i);
              ++part[pattern];
            }
            return part;
          },
          [](Counts a, const Counts& b) {
            for (int k = 0; k < kPatterns; ++k) a[k] += b[k];
            return a;
          });
      for (int k = 0; k < kPatterns; ++k) tables_[g * counted_ + p].change(k, counts[k]);
    }
  }
}

unsigned Level::neighbors(std::uint32_t voxel) const {
  const Vec3i at = place(voxel);
  unsigned out = 0;
  for (int a = 0; a < 3; ++a) {
    const std::uint32_t round = step_[a] * (size_[a] - 1);
    out |= 1u << field_[at[a] > 0 ? voxel - step_[a] : voxel + round];
    out |= 1u << field_[at[a] < size_[a] - 1 ? voxel + step_[a] : voxel - round];
  }
  return out;
}

std::vector<std::uint32_t> Level::interface(const Work& work) const {
  using List = std::vector<std::uint32_t>;
  return work.quiet().reduce(
      field_.size(), 1 << 16, List{},
      [&](std::size_t begin, std::size_t end) {
        List out;
        for (std::size_t v = begin; v < end; ++v)
          if (neighbors(v) & ~(1u << field_[v])) out.push_back(v);
        return out;
      },
      [](List a, const List& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
}

double Level::gain(std::uint32_t voxel, const std::vector<Around>& around, int to, std::uint64_t seed,
                   double temperature) const {
  const double c = cost(around, field_[voxel], to);
  if (temperature <= 0) return -c;
  return -c - temperature * std::log(1 - Random(seed, 2 + to, voxel).uniform());
}

int Level::propose(std::uint32_t voxel, const std::vector<Around>& around, std::uint64_t seed,
                   double temperature) const {
  const unsigned others = neighbors(voxel);
  int best = field_[voxel];
  double most = 0;
  for (int to = 0; to < phases_; ++to) {
    if (to == field_[voxel] || !(others >> to & 1)) continue;
    if (const double g = gain(voxel, around, to, seed, temperature); g > most) {
      most = g;
      best = to;
    }
  }
  return best;
}

std::size_t Level::sweep(std::uint64_t seed, double temperature, const Work& work) {
  std::vector<std::uint32_t> order = interface(work);
  Random random(seed, 1);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  std::vector<std::uint8_t> wanted(kBatch);
  std::vector<Around> around(groups_.size());
  std::size_t changes = 0;
  for (std::size_t first = 0; first < order.size(); first += kBatch) {
    const std::size_t n = std::min(kBatch, order.size() - first);
    work.quiet().parallel(n, 256, [&](std::size_t begin, std::size_t end) {
      std::vector<Around> own(groups_.size());
      for (std::size_t i = begin; i < end; ++i) {
        gather(order[first + i], own);
        wanted[i] = propose(order[first + i], own, seed, temperature);
      }
    });
    // Weigh them again, one after the other, on the counts that the changes before have left.
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t v = order[first + i];
      if (wanted[i] == field_[v]) continue;
      gather(v, around);
      if (gain(v, around, wanted[i], seed, temperature) <= 0) continue;
      apply(v, around, wanted[i]);
      ++changes;
    }
    work.done(first + n, order.size());
  }
  return changes;
}

void Level::settle(const std::vector<std::int64_t>& count, const Work& work) {
  std::vector<std::int64_t> excess(phases_, 0);
  for (const std::uint8_t p : field_) ++excess[p];
  for (int p = 0; p < phases_; ++p) excess[p] -= count[p];
  for (int from = 0; from < phases_; ++from)
    for (int to = 0; to < phases_; ++to)
      if (const std::int64_t n = std::min(excess[from], -excess[to]); n > 0) {
        move_cheapest(from, to, n, work);
        excess[from] -= n;
        excess[to] += n;
      }
}

void Level::move_cheapest(int from, int to, std::size_t n, const Work& work) {
  std::vector<std::uint32_t> at;
  for (const std::uint32_t v : interface(work))
    if (field_[v] == from && (neighbors(v) >> to & 1)) at.push_back(v);
  if (at.size() < n) {  // the phases hardly touch
    at.clear();
    for (std::size_t v = 0; v < field_.size(); ++v)
      if (field_[v] == from) at.push_back(v);
  }
  std::vector<std::pair<double, std::uint32_t>> costs(at.size());
  work.parallel(at.size(), 4096, [&](std::size_t begin, std::size_t end) {
    std::vector<Around> around(groups_.size());
    for (std::size_t i = begin; i < end; ++i) {
      gather(at[i], around);
      costs[i] = {cost(around, from, to), at[i]};
    }
  });
  std::partial_sort(costs.begin(), costs.begin() + n, costs.end());
  std::vector<Around> around(groups_.size());
  for (std::size_t k = 0; k < n; ++k) {
    gather(costs[k].second, around);
    apply(costs[k].second, around, to);
  }
}

double Level::mismatch() const {
  double sum = 0;
  for (const PatternCounts& t : tables_)
    for (int k = 0; k < kPatterns; ++k)
      sum += t.weight[k] * static_cast<double>(t.excess[k]) * static_cast<double>(t.excess[k]);
  return sum / field_.size();
}

}  // namespace terrazzo::media_solid
