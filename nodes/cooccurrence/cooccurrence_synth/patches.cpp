#include "nodes/cooccurrence/cooccurrence_synth/patches.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/random.h"

namespace terrazzo::cooccurrence_synth {
namespace {

// The field's co-occurrence counts, kept up to date.
class Usage {
 public:
  Usage(const LevelField& field, const Cooccurrence& wanted, bool periodic)
      : field_(field),
        levels_(wanted.levels),
        periodic_(periodic),
        offsets_(wanted.offsets),
        now_(measure_cooccurrence(field, wanted.levels, wanted.offsets, periodic)) {
    for (std::size_t d = 0; d < offsets_.size(); ++d)
      for (int i = 0; i < levels_ * levels_; ++i)
        share_.push_back(static_cast<float>(static_cast<double>(wanted.counts[d * levels_ * levels_ + i]) /
                                            wanted.pairs[d]));
  }

  // For each level: how often it occurs beside this pixel's neighbors over how often it should, to the power
  // of 1.5.
  void overuse(int x, int y, std::vector<float>& use) const {
    const float little = 1e-3f * offsets_.size();
    std::vector<float> want(use.size(), little);
    std::fill(use.begin(), use.end(), little);
    for (std::size_t d = 0; d < offsets_.size(); ++d) {
      const float k = 1.0f / now_.pairs[d];
      const int after = level_at(x + offsets_[d].x(), y + offsets_[d].y()),
                before = level_at(x - offsets_[d].x(), y - offsets_[d].y());
      for (int t = 0; t < levels_; ++t) {
        if (after >= 0) take(now_.at(d, t, after), k, use[t], want[t]);
        if (before >= 0) take(now_.at(d, before, t), k, use[t], want[t]);
      }
    }
    for (std::size_t t = 0; t < use.size(); ++t) {
      use[t] /= want[t];
      use[t] *= std::sqrt(use[t]);
    }
  }

  // Call before the field's pixel changes.
  void change(int x, int y, int from, int to) {
    for (std::size_t d = 0; d < offsets_.size(); ++d) {
      if (const int after = level_at(x + offsets_[d].x(), y + offsets_[d].y()); after >= 0) {
        --now_.counts[now_.at(d, from, after)];
        ++now_.counts[now_.at(d, to, after)];
      }
      if (const int before = level_at(x - offsets_[d].x(), y - offsets_[d].y()); before >= 0) {
        --now_.counts[now_.at(d, before, from)];
        ++now_.counts[now_.at(d, before, to)];
      }
    }
  }

 private:
  void take(std::size_t entry, float k, float& use, float& want) const {
    use += now_.counts[entry] * k;
    want += share_[entry];
  }
  int level_at(int x, int y) const {
    const int w = field_.size.x(), h = field_.size.y();
    if (x < 0 || y < 0 || x >= w || y >= h) {
      if (!periodic_) return -1;
      x = (x + w) % w;
      y = (y + h) % h;
    }
    return field_.at[field_.index(x, y)];
  }

  const LevelField& field_;
  int levels_;
  bool periodic_;
  std::vector<Vec3i> offsets_;
  Cooccurrence now_;
  std::vector<float> share_;
};

constexpr int kReach = 4, kRounds = 4, kRandom = 16;

// Where pixels of the field come from.
class PatchSearch {
 public:
  PatchSearch(const Image& source, const std::vector<LevelField>& sections, const ColorLevels& levels,
              const Cooccurrence& wanted, bool periodic, std::uint64_t seed, LevelField& field)
      : source_width_(source.width),
        source_height_(source.height),
        periodic_(periodic),
        seed_(seed),
        field_(field),
        pixels_of_(static_cast<std::size_t>(levels.count())),
        now_(field.at.size()),
        known_(field.at.size(), 0),
        from_(field.at.size(), 0),
        usage_(field, wanted, periodic),
        use_(static_cast<std::size_t>(levels.count())) {
    for (const auto& section : sections) level_.insert(level_.end(), section.at.begin(), section.at.end());
    for (std::size_t i = 0; i < level_.size(); ++i) {
      positions_.push_back(levels.position(source.pixels[i]));
      if (level_[i] != kNoLevel) pixels_of_[level_[i]].push_back(static_cast<std::uint32_t>(i));
    }
  }

  // Looks for a better source of one pixel.
  void visit(int x, int y, int round) {
    const std::size_t p = field_.index(x, y);
    usage_.overuse(x, y, use_);
    Choice choice{from_[p], 1e30f};
    if (known_[p]) choice.least = use_[level_[choice.best]] * mismatch(x, y, choice.best, 1e30f);
    try_neighbors(x, y, choice);
    const auto& same = pixels_of_[field_.at[p]];
    Random random(seed_, 0x0cc8 + static_cast<std::uint64_t>(round), p);
    for (int k = 0; k < kRandom && !same.empty(); ++k)
      try_source(x, y, same[random.below(same.size())], choice);
    if (choice.least >= 1e30f) return;
    const std::uint32_t best = choice.best;
    if (level_[best] != field_.at[p]) usage_.change(x, y, field_.at[p], level_[best]);
    field_.at[p] = level_[best];
    from_[p] = best;
    now_[p] = positions_[best];
    known_[p] = 1;
  }

  std::vector<std::uint32_t> sources() && { return std::move(from_); }

 private:
  struct Choice {
    std::uint32_t best;
    float least;
  };

  // Tries the sources of the neighbors, shifted.
  void try_neighbors(int x, int y, Choice& choice) const {
    const int w = field_.size.x(), h = field_.size.y(), sw = source_width_, sh = source_height_;
    const std::size_t p = field_.index(x, y);
    for (int v = -1; v <= 1; ++v)
      for (int u = -1; u <= 1; ++u) {
        int px = x + u, py = y + v;
        if (px < 0 || py < 0 || px >= w || py >= h) {
          if (!periodic_) continue;
          px = (px + w) % w;
          py = (py + h) % h;
        }
        const std::size_t q = field_.index(px, py);
        if (!known_[q] || q == p) continue;
        const int sx = static_cast<int>(from_[q]) % sw - u, sy = static_cast<int>(from_[q]) / sw % sh - v;
        if (sx < 0 || sy < 0 || sx >= sw || sy >= sh) continue;
        try_source(x, y, static_cast<std::uint32_t>(static_cast<int>(from_[q]) - v * sw - u), choice);
      }
  }

  void try_source(int x, int y, std::uint32_t s, Choice& choice) const {
    if (level_[s] == kNoLevel) return;
    const float use = use_[level_[s]];
    const float m = use * mismatch(x, y, s, choice.least / use);
    if (m < choice.least) {
      choice.least = m;
      choice.best = s;
    }
  }

  // Of the neighborhoods of a pixel and of source s. Stops above the limit.
  float mismatch(int x, int y, std::uint32_t s, float limit) const {
    const int w = field_.size.x(), h = field_.size.y(), sw = source_width_, sh = source_height_;
    const int sx = static_cast<int>(s) % sw, sy = static_cast<int>(s) / sw % sh;
    const std::size_t first = s - static_cast<std::size_t>(sy) * sw - sx;
    float sum = 0;
    for (int v = -kReach; v <= kReach; ++v) {
      int py = y + v;
      if (py < 0 || py >= h) {
        if (!periodic_) continue;
        py = (py + h) % h;
      }
      for (int u = -kReach; u <= kReach; ++u) {
        int px = x + u;
        if (px < 0 || px >= w) {
          if (!periodic_) continue;
          px = (px + w) % w;
        }
        const std::size_t p = field_.index(px, py);
        if (!known_[p] || (u == 0 && v == 0)) continue;
        const int qx = sx + u, qy = sy + v;
        if (qx < 0 || qy < 0 || qx >= sw || qy >= sh)
          sum += 0.02f;
        else
          sum += (now_[p] - positions_[first + static_cast<std::size_t>(qy) * sw + qx]).squaredNorm();
      }
      if (sum >= limit) return sum;
    }
    return sum;
  }

  int source_width_, source_height_;
  bool periodic_;
  std::uint64_t seed_;
  LevelField& field_;
  std::vector<Vec3f> positions_;     // colors of the source
  std::vector<std::uint8_t> level_;  // of each source pixel
  std::vector<std::vector<std::uint32_t>> pixels_of_;
  std::vector<Vec3f> now_;           // colors of the field
  std::vector<std::uint8_t> known_;  // whether a pixel of the field has a source
  std::vector<std::uint32_t> from_;
  Usage usage_;
  std::vector<float> use_;
};

}  // namespace

std::vector<std::uint32_t> patch_sources(const Image& source, const std::vector<LevelField>& sections,
                                         const ColorLevels& levels, const Cooccurrence& wanted, bool periodic,
                                         std::uint64_t seed, LevelField& field, const Work& work) {
  PatchSearch search(source, sections, levels, wanted, periodic, seed, field);
  const int w = field.size.x(), h = field.size.y();
  for (int round = 0; round < kRounds; ++round)
    for (int row = 0; row < h; ++row) {
      work.check();
      work.progress((round + static_cast<double>(row) / h) / kRounds);
      for (int column = 0; column < w; ++column)
        search.visit(round % 2 ? w - 1 - column : column, round % 2 ? h - 1 - row : row, round);
    }
  return std::move(search).sources();
}

}  // namespace terrazzo::cooccurrence_synth
