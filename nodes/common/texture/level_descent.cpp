#include "nodes/common/texture/level_descent.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

using Eight = std::int32_t __attribute__((vector_size(32), aligned(4), may_alias));
using EightD = double __attribute__((vector_size(64), aligned(8), may_alias));
constexpr int kLanes = 8;

// Fisher–Yates shuffle.
void shuffle(std::vector<std::uint32_t>& order, std::uint64_t seed) {
  Random random(seed, 0x0cc5);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
}

// Branch-free, since the condition is unpredictable.
inline int row_if(bool yes, int row, int other) { return other + (-static_cast<int>(yes) & (row - other)); }

}  // namespace

LevelDescent::LevelDescent(const LevelField& start, int levels, bool periodic,
                           const std::vector<PairTarget>& targets)
    : levels_(levels),
      width_((levels + kLanes - 1) / kLanes * kLanes),
      periodic_(periodic),
      size_(start.size),
      pad_(Vec3i::Zero()) {
  for (const auto& t : targets) pad_ = pad_.cwiseMax(t.offset.cwiseAbs());
  padded_ = size_ + 2 * pad_;
  levels_of_.assign(voxels_in(padded_), static_cast<std::uint8_t>(levels));
  order_.reserve(start.at.size());
  for (int z = 0; z < size_.z(); ++z)
    for (int y = 0; y < size_.y(); ++y)
      for (int x = 0; x < size_.x(); ++x) {
        const std::uint32_t at =
            (static_cast<std::size_t>(z + pad_.z()) * padded_.y() + y + pad_.y()) * padded_.x() + x +
            pad_.x();
        order_.push_back(at);
        place(at, start.at[start.index(x, y, z)]);
      }
  const auto rows = static_cast<std::size_t>(levels + 1) * width_;
  by_home_.assign(targets.size() * rows, 0);
  by_remote_.assign(targets.size() * rows, 0);
  std::vector<Vec3i> offsets;
  for (const auto& t : targets) offsets.push_back(t.offset);
  const Cooccurrence now = measure_cooccurrence(start, levels, offsets, periodic);
  for (std::size_t d = 0; d < targets.size(); ++d) {
    const Vec3i& o = targets[d].offset;
    step_.push_back((static_cast<std::ptrdiff_t>(o.z()) * padded_.y() + o.y()) * padded_.x() + o.x());
    const double pairs = now.pairs[d], pixels = start.at.size();
    pairs_.push_back(pairs);
    weight_.push_back(pixels / pairs * (pixels / pairs));
    weighted_ |= now.pairs[d] != now.pairs[0];
    target_.insert(target_.end(), targets[d].counts.begin(), targets[d].counts.end());
    for (int h = 0; h < levels; ++h)
      for (int r = 0; r < levels; ++r) {
        const std::int32_t difference =
            now.counts[now.at(d, h, r)] - targets[d].counts[static_cast<std::size_t>(h) * levels + r];
        by_home_[d * rows + static_cast<std::size_t>(h) * width_ + r] = difference;
        by_remote_[d * rows + static_cast<std::size_t>(r) * width_ + h] = difference;
      }
  }
}

// Sets a pixel and its copies beyond the edges.
void LevelDescent::place(std::uint32_t padded, std::uint8_t level) {
  levels_of_[padded] = level;
  if (!periodic_) return;
  const int x = static_cast<int>(padded) % padded_.x(),
            y = static_cast<int>(padded) / padded_.x() % padded_.y(),
            z = static_cast<int>(padded) / padded_.x() / padded_.y();
  const auto copies = [](int at, int pad, int size, int out[3]) {
    int n = 0;
    out[n++] = at;
    if (at + size < size + 2 * pad) out[n++] = at + size;
    if (at - size >= 0) out[n++] = at - size;
    return n;
  };
  int xs[3], ys[3], zs[3];
  const int nx = copies(x, pad_.x(), size_.x(), xs), ny = copies(y, pad_.y(), size_.y(), ys),
            nz = copies(z, pad_.z(), size_.z(), zs);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) levels_of_[voxel_at(xs[i], ys[j], zs[k], padded_)] = level;
}

template <int Vectors, bool Weighted>
std::size_t LevelDescent::visit(const std::uint32_t* pixels, std::size_t n) {
  constexpr int kWidth = Vectors * kLanes;
  const int levels = levels_;
  const auto rows = static_cast<std::size_t>(levels + 1) * kWidth;
  const std::size_t offsets = step_.size();
  // unit[k] is 1 in lane k; row `levels` is zero.
  alignas(32) std::int32_t unit[(Vectors * kLanes + 1) * kWidth] = {};
  for (int k = 0; k < levels; ++k) unit[k * kWidth + k] = 1;
  std::size_t changed = 0;
  for (std::size_t p = 0; p < n; ++p) {
    const std::uint8_t* at = levels_of_.data() + pixels[p];
    const int now = *at;
    Eight cost[Vectors] = {};
    EightD weighted[Vectors] = {};
    for (std::size_t d = 0; d < offsets; ++d) {
      const int after = at[step_[d]], before = at[-step_[d]];
      const auto* remote =
          reinterpret_cast<const Eight*>(&by_remote_[d * rows + static_cast<std::size_t>(after) * kWidth]);
      const auto* home =
          reinterpret_cast<const Eight*>(&by_home_[d * rows + static_cast<std::size_t>(before) * kWidth]);
      // Removing the pixel decreases D[now, after] and D[before, now] by one. This affects a candidate's two
      // entries at t = now, at t = before if after = now, and at t = after if before = now.
      const auto* own = reinterpret_cast<const Eight*>(unit + now * kWidth);
      const auto* first =
          reinterpret_cast<const Eight*>(unit + row_if(after == now, before, levels) * kWidth);
      const auto* second =
          reinterpret_cast<const Eight*>(unit + row_if(before == now, after, levels) * kWidth);
      const auto* both =
          reinterpret_cast<const Eight*>(unit + row_if(before == after, before, levels) * kWidth);
      const int ends = (after < levels) + (before < levels);
      for (int v = 0; v < Vectors; ++v) {
        const Eight sum = remote[v] + home[v] - own[v] * ends - first[v] - second[v] + both[v];
        if constexpr (Weighted)
          weighted[v] += __builtin_convertvector(sum, EightD) * weight_[d];
        else
          cost[v] += sum;
      }
    }
    int best = now;
    if constexpr (Weighted) {
      const auto* c = reinterpret_cast<const double*>(weighted);
      for (int t = 0; t < levels; ++t)
        if (c[t] < c[best]) best = t;
    } else {
      const auto* c = reinterpret_cast<const std::int32_t*>(cost);
      for (int t = 0; t < levels; ++t)
        if (c[t] < c[best]) best = t;
    }
    if (best == now) continue;
    ++changed;
    for (std::size_t d = 0; d < offsets; ++d) {
      const int after = at[step_[d]], before = at[-step_[d]];
      std::int32_t *remote = &by_remote_[d * rows], *home = &by_home_[d * rows];
      if (after < levels) {
        --home[now * kWidth + after];
        ++home[best * kWidth + after];
        --remote[after * kWidth + now];
        ++remote[after * kWidth + best];
      }
      if (before < levels) {
        --home[before * kWidth + now];
        ++home[before * kWidth + best];
        --remote[now * kWidth + before];
        ++remote[best * kWidth + before];
      }
    }
    place(pixels[p], best);
  }
  return changed;
}

std::size_t LevelDescent::sweep(std::uint64_t seed, const Work& work) {
  shuffle(order_, seed);
  std::size_t changed = 0;
  constexpr std::size_t kStep = 4096;
  for (std::size_t i = 0; i < order_.size(); i += kStep) {
    work.check();
    work.done(i, order_.size());
    const std::uint32_t* pixels = order_.data() + i;
    const std::size_t n = std::min(kStep, order_.size() - i);
    switch (width_ / kLanes * 2 + weighted_) {
      case 2:
        changed += visit<1, false>(pixels, n);
        break;
      case 3:
        changed += visit<1, true>(pixels, n);
        break;
      case 4:
        changed += visit<2, false>(pixels, n);
        break;
      case 5:
        changed += visit<2, true>(pixels, n);
        break;
      case 6:
        changed += visit<3, false>(pixels, n);
        break;
      case 7:
        changed += visit<3, true>(pixels, n);
        break;
      case 8:
        changed += visit<4, false>(pixels, n);
        break;
      default:
        changed += visit<4, true>(pixels, n);
        break;
    }
  }
  return changed;
}

double LevelDescent::error() const {
  const auto rows = static_cast<std::size_t>(levels_ + 1) * width_;
  double sum = 0;
  for (std::size_t d = 0; d < step_.size(); ++d) {
    double squares = 0;
    for (int h = 0; h < levels_; ++h)
      for (int r = 0; r < levels_; ++r) {
        const double e = by_home_[d * rows + static_cast<std::size_t>(h) * width_ + r];
        squares += e * e;
      }
    sum += squares / (pairs_[d] * pairs_[d]);
  }
  return sum;
}

LevelField LevelDescent::field() const {
  LevelField out(size_);
  std::size_t i = 0;
  for (int z = 0; z < size_.z(); ++z)
    for (int y = 0; y < size_.y(); ++y) {
      const std::size_t row =
          (static_cast<std::size_t>(z + pad_.z()) * padded_.y() + y + pad_.y()) * padded_.x() + pad_.x();
      std::memcpy(&out.at[i], &levels_of_[row], static_cast<std::size_t>(size_.x()));
      i += size_.x();
    }
  return out;
}

std::vector<std::int32_t> LevelDescent::counts() const {
  const auto rows = static_cast<std::size_t>(levels_ + 1) * width_;
  std::vector<std::int32_t> out = target_;
  std::size_t i = 0;
  for (std::size_t d = 0; d < step_.size(); ++d)
    for (int h = 0; h < levels_; ++h)
      for (int r = 0; r < levels_; ++r)
        out[i++] += by_home_[d * rows + static_cast<std::size_t>(h) * width_ + r];
  return out;
}

LevelField level_noise(const std::vector<const LevelField*>& source, int levels, const Vec3i& size,
                       std::uint64_t seed) {
  std::vector<std::int64_t> count(levels, 0);
  std::int64_t total = 0;
  for (const auto* f : source)
    for (const auto level : f->at)
      if (level < levels) {
        ++count[level];
        ++total;
      }
  LevelField out(size);
  const std::int64_t n = out.at.size();
  std::int64_t sum = 0;
  std::size_t i = 0;
  for (int k = 0; k < levels; ++k) {
    sum += count[k];
    const std::size_t end = total > 0 ? sum * n / total : n;
    for (; i < end; ++i) out.at[i] = k;
  }
  Random random(seed, 0x0cc0);
  for (std::size_t j = out.at.size(); j > 1; --j) std::swap(out.at[j - 1], out.at[random.below(j)]);
  return out;
}

}  // namespace terrazzo
