#include "nodes/media/annealing/level.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::annealing {
namespace {

constexpr std::size_t kBatch = 4096;  // voxels that decide on the same counts

// A line of five pixels as it lies in a pattern, where pixels of one column follow each other: bit 3i is
// pixel i.
using Spread = std::array<std::uint16_t, 1024>;

constexpr Spread spread_of(const std::array<int, 5>& pixels) {
  Spread out{};
  for (int index = 0; index < 1024; ++index)
    for (int i = 0; i < 5; ++i) out[index] |= (index >> pixels[i] & 1) << (3 * i);
  return out;
}

// For spacings 1, 2 and 4. The last two pixels of a line of spacing 4 are moved 7 bits to the right, between
// the others, so that the table stays small.
constexpr Spread kSpread[3] = {spread_of({0, 1, 2, 3, 4}), spread_of({0, 2, 4, 6, 8}),
                               spread_of({0, 4, 8, 5, 9})};

// `row`: bit 0 is the first pixel.
std::uint32_t spread(std::uint32_t row, int spacing) {
  switch (spacing) {
    case 1:
      return kSpread[0][row & 31];
    case 2:
      return kSpread[1][row & 1023];
    default:
      row &= 0x11111;
      return kSpread[2][(row | row >> 7) & 1023];
  }
}

// The voxel in the middle is the last pixel of the first pattern, and the first of the last.
constexpr int kMiddle[3][3] = {{256, 32, 4}, {128, 16, 2}, {64, 8, 1}};

}  // namespace

void Level::PatternCounts::change(int pattern, std::int64_t by) {
  const std::int64_t e = excess[pattern] += by;
  const float w = weight[pattern];
  step[pattern] = {w * static_cast<float>(1 - 2 * e), w * static_cast<float>(1 + 2 * e)};
}

Level::Level(std::vector<std::uint8_t> field, const Vec3i& size, int phases,
             const std::vector<PatternTarget>& targets, double floor, Ends ends, const Work& work)
    : field_(std::move(field)),
      size_(size),
      ends_(ends),
      free_(ends == Ends::Frozen ? Layers{kFrozen, size.z() - 2 * kFrozen} : Layers{0, size.z()}),
      step_{1, static_cast<std::uint32_t>(size.x()), static_cast<std::uint32_t>(size.x()) * size.y()},
      phases_(phases),
      counted_(phases == 2 ? 1 : phases),
      first_(phases == 2 ? 1 : 0) {
  for (const PatternTarget& t : targets) {
    groups_.push_back(group_of(t.axis, t.spacing));
    for (int p = first_; p < phases_; ++p) tables_.push_back(table_of(groups_.back(), t.phase[p], floor));
  }
  for (int p = first_; p < phases_; ++p) bits_.push_back(bits_of(p, work));
  count_all(work);
}

Level::Group Level::group_of(int axis, int spacing) const {
  Group out{axis, spacing, axis == 0 ? 1 : 0, axis == 2 ? 1 : 2, 1, {}, {}, {}};
  // Lines are numbered along x or y, and then along z.
  const std::uint32_t across = size_[axis == 0 ? 0 : 1];
  out.slice = axis == 2 ? across : 1;
  const int n = size_[out.row];
  for (int i = 0; i < n; ++i)
    for (int k = -2; k <= 2; ++k) {
      const int at = (i + k * spacing) % n;
      out.lines.push_back((at < 0 ? at + n : at) * (axis == 2 ? 1 : across));
    }
  out.counted = free_;
  const int reach = axis == 2 ? 0 : 2 * spacing;
  if (ends_ == Ends::Frozen) out.counted = {free_.first - reach, free_.count + reach};
  if (ends_ == Ends::Open) out.counted.count -= reach;
  out.rows.assign(size_.z(), 7);
  if (ends_ == Ends::Open && axis != 2)
    for (int z = 0; z < size_.z(); ++z)
      for (int j = 0; j < 3; ++j)
        if (const int first = z + (j - 2) * spacing; first < 0 || first >= out.counted.count)
          out.rows[z] &= ~(1 << j);
  return out;
}

Level::PatternCounts Level::table_of(const Group& group, const Frequencies& frequencies, double floor) const {
  PatternCounts out;
  out.places = static_cast<double>(group.counted.count) * step_[2];
  for (int k = 0; k < kPatterns; ++k) {
    const double expected = frequencies[k] * out.places;
    out.excess[k] = -std::llround(expected);
    out.weight[k] = static_cast<float>(1 / (expected + floor * out.places));
  }
  return out;
}

Level::Bits Level::bits_of(int phase, const Work& work) const {
  const std::size_t depth = size_.z(), slice = step_[2];
  Bits out{{size_.x(), size_.y() * depth}, {size_.y(), size_.x() * depth}};
  // Slices across z share no bytes.
  work.quiet().parallel(depth, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin * slice; v < end * slice; ++v)
      if (field_[v] == phase) set(out, place(v), true);
  });
  return out;
}

void Level::set(Bits& bits, const Vec3i& at, bool in) const {
  bits.along_x.set(pixel_at(at.y(), at.z(), size_.y()), at.x(), in);
  bits.along_y.set(pixel_at(at.x(), at.z(), size_.x()), at.y(), in);
}

Vec3i Level::place(std::uint32_t voxel) const {
  const int row = voxel / step_[1];
  return {static_cast<int>(voxel % step_[1]), row % size_.y(), row / size_.y()};
}

inline Level::Columns Level::around(const Group& group, const Bits& bits, const Vec3i& at) const {
  const std::uint32_t* lines = &group.lines[kSpan * at[group.row]];
  const PhaseBits& rows = group.axis == 0 ? bits.along_y : bits.along_x;
  const std::uint32_t slice = at[group.axis] * group.slice;
  std::array<std::uint32_t, kSpan> row;
  for (int j = 0; j < kSpan; ++j)
    row[j] =
        spread(rows.around(slice + lines[j], at[group.column]) >> (PhaseBits::kReach - 2 * group.spacing),
               group.spacing);
  Columns out;
  for (int j = 0; j < 3; ++j) out[j] = row[j] | row[j + 1] << 1 | row[j + 2] << 2;
  return out;
}

double Level::cost_of(const Vec3i& at, int phase) const {
  double sum = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Step* step = tables_[g * counted_ + (phase - first_)].step.data();
    const Columns columns = around(groups_[g], bits_[phase - first_], at);
    const unsigned rows = groups_[g].rows[at.z()];
    float remove = 0, add = 0;
    for (int j = 0; j < 3; ++j) {
      if (!(rows >> j & 1)) continue;
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t pattern = columns[j] >> (3 * i) & (kPatterns - 1);
        remove += step[pattern].remove;
        add += step[pattern ^ kMiddle[j][i]].add;
      }
    }
    sum += remove + add;
  }
  return sum;
}

double Level::cost(std::uint32_t voxel, const Vec3i& at, int to) const {
  return phases_ == 2 ? cost_of(at, 1) : cost_of(at, field_[voxel]) + cost_of(at, to);
}

void Level::change(const Vec3i& at, int phase, bool in) {
  Bits& bits = bits_[phase - first_];
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    PatternCounts& table = tables_[g * counted_ + (phase - first_)];
    const Columns columns = around(groups_[g], bits, at);
    const unsigned rows = groups_[g].rows[at.z()];
    for (int j = 0; j < 3; ++j) {
      if (!(rows >> j & 1)) continue;
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t pattern = columns[j] >> (3 * i) & (kPatterns - 1);
        table.change(pattern, -1);
        table.change(pattern ^ kMiddle[j][i], 1);
      }
    }
  }
  set(bits, at, in);
}

void Level::apply(std::uint32_t voxel, int to) {
  const Vec3i at = place(voxel);
  if (field_[voxel] >= first_) change(at, field_[voxel], false);
  if (to >= first_) change(at, to, true);
  field_[voxel] = to;
}

void Level::count_all(const Work& work) {
  using Counts = std::array<std::int64_t, kPatterns>;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Layers& layers = groups_[g].counted;
    const std::size_t first = static_cast<std::size_t>(layers.first) * step_[2];
    for (int p = 0; p < counted_; ++p) {
      const Counts counts = work.quiet().reduce(
          static_cast<std::size_t>(layers.count) * step_[2], 1 << 16, Counts{},
          [&](std::size_t begin, std::size_t end) {
            Counts part{};
            // The pattern whose lower left pixel is the voxel.
            for (std::size_t v = first + begin; v < first + end; ++v)
              ++part[around(groups_[g], bits_[p], place(v))[2] >> 6];
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

unsigned Level::neighbors(std::uint32_t voxel, const Vec3i& at) const {
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
  const std::size_t rows = static_cast<std::size_t>(free_.count) * size_.y(),
                    first = static_cast<std::size_t>(free_.first) * size_.y();
  return work.quiet().reduce(
      rows, std::max<std::size_t>(1, (1 << 16) / step_[1]), List{},
      [&](std::size_t begin, std::size_t end) {
        List out;
        std::uint32_t v = (first + begin) * step_[1];
        for (std::size_t row = begin; row < end; ++row) {
          Vec3i at = place(v);
          for (; at.x() < size_.x(); ++at.x(), ++v)
            if (neighbors(v, at) & ~(1u << field_[v])) out.push_back(v);
        }
        return out;
      },
      [](List a, const List& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
      });
}

double Level::gain(std::uint32_t voxel, const Vec3i& at, int to, std::uint64_t seed,
                   double temperature) const {
  const double c = cost(voxel, at, to);
  if (temperature <= 0) return -c;
  return -c - temperature * std::log(1 - Random(seed, 2 + to, voxel).uniform());
}

int Level::propose(std::uint32_t voxel, std::uint64_t seed, double temperature) const {
  const Vec3i at = place(voxel);
  const unsigned others = neighbors(voxel, at);
  int best = field_[voxel];
  double most = 0;
  for (int to = 0; to < phases_; ++to) {
    if (to == field_[voxel] || !(others >> to & 1)) continue;
    if (const double g = gain(voxel, at, to, seed, temperature); g > most) {
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
  std::size_t changes = 0;
  for (std::size_t first = 0; first < order.size(); first += kBatch) {
    const std::size_t n = std::min(kBatch, order.size() - first);
    work.quiet().parallel(n, 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) wanted[i] = propose(order[first + i], seed, temperature);
    });
    // Weigh them again, one after the other, on the counts that the changes before have left.
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t v = order[first + i];
      if (wanted[i] == field_[v] || gain(v, place(v), wanted[i], seed, temperature) <= 0) continue;
      apply(v, wanted[i]);
      ++changes;
    }
    work.done(first + n, order.size());
  }
  return changes;
}

void Level::settle(const std::vector<std::int64_t>& count, const Work& work) {
  std::vector<std::int64_t> excess(phases_, 0);
  const std::size_t first = free_.first * step_[2], last = first + free_.count * step_[2];
  for (std::size_t v = first; v < last; ++v) ++excess[field_[v]];
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
    if (field_[v] == from && (neighbors(v, place(v)) >> to & 1)) at.push_back(v);
  if (at.size() < n) {  // the phases hardly touch
    at.clear();
    const std::size_t first = free_.first * step_[2], last = first + free_.count * step_[2];
    for (std::size_t v = first; v < last; ++v)
      if (field_[v] == from) at.push_back(v);
  }
  std::vector<std::pair<double, std::uint32_t>> costs(at.size());
  work.parallel(at.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) costs[i] = {cost(at[i], place(at[i]), to), at[i]};
  });
  std::partial_sort(costs.begin(), costs.begin() + n, costs.end());
  for (std::size_t k = 0; k < n; ++k) apply(costs[k].second, to);
}

double Level::mismatch() const {
  double sum = 0;
  for (const PatternCounts& t : tables_)
    for (int k = 0; k < kPatterns; ++k)
      sum += t.weight[k] * static_cast<double>(t.excess[k]) * static_cast<double>(t.excess[k]) / t.places;
  return sum;
}

}  // namespace terrazzo::annealing
