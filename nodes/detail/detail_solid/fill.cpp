#include "nodes/detail/detail_solid/fill.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kPatch = 7;
constexpr int kRounds = 5;            // per level
constexpr int kCoarsest = 24;         // pixels of the shorter side at the coarsest level
constexpr std::size_t kEnough = 400;  // source patches that suffice
constexpr int kCell = 4;              // pixels: sources whose corners share a cell wear out together

// A pixel of the half-size picture is known if at least two of its four are.
PartialPicture halved(const PartialPicture& p) {
  PartialPicture out;
  out.width = p.width / 2;
  out.height = p.height / 2;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      Vec3f sum = Vec3f::Zero();
      int count = 0;
      for (int c = 0; c < 4; ++c) {
        const std::size_t at = static_cast<std::size_t>(2 * y + c / 2) * p.width + 2 * x + c % 2;
        if (p.known[at]) {
          sum += p.value[at];
          ++count;
        }
      }
      out.value.push_back(count ? Vec3f(sum / static_cast<float>(count)) : Vec3f::Zero());
      out.known.push_back(count >= 2);
    }
  return out;
}

class Level {
 public:
  Level(const PartialPicture& source, std::uint64_t seed)
      : source_(source),
        picture_(source.value),
        columns_(source.width - kPatch + 1),
        rows_(source.height - kPatch + 1),
        seed_(seed) {
    choose_sources();
    choose_targets();
  }
  const std::vector<Vec3f>& picture() const { return picture_; }

  // Starts from random sources, with the unknown pixels set to values of random known ones.
  void start_at_random() {
    std::vector<std::size_t> known;
    for (std::size_t i = 0; i < source_.known.size(); ++i)
      if (source_.known[i]) known.push_back(i);
    for (std::size_t i = 0; i < picture_.size(); ++i)
      if (!source_.known[i]) picture_[i] = source_.value[known[Random(seed_, 1, i).below(known.size())]];
    match_.assign(pixels_in(columns_, rows_), 0);
    for (const std::int32_t t : targets_) match_[t] = random_source(2, t);
  }
  // Starts from the matches of the level with half as many pixels.
  void start_from(const Level& coarse) {
    match_.assign(pixels_in(columns_, rows_), 0);
    for (const std::int32_t t : targets_) {
      const int x = std::min(t % columns_ / 2, coarse.columns_ - 1),
                y = std::min(t / columns_ / 2, coarse.rows_ - 1);
      const std::int32_t m = coarse.match_[static_cast<std::size_t>(y) * coarse.columns_ + x];
      const int u = std::min(m % coarse.columns_ * 2 + t % columns_ % 2, columns_ - 1),
                v = std::min(m / coarse.columns_ * 2 + t / columns_ % 2, rows_ - 1);
      const std::int32_t s = v * columns_ + u;
      match_[t] = is_source_[s] ? s : random_source(2, t);
    }
    vote(false, true);
  }
  void run(bool finest, const Work& work) {
    if (targets_.empty()) return;  // small holes vanish at coarse levels
    for (int round = 0; round < kRounds; ++round) {
      work.check();
      search(round, work);
      vote(finest && round + 1 == kRounds, false);
    }
  }

 private:
  std::int32_t random_source(std::uint64_t stream, std::int32_t item) const {
    return sources_[Random(seed_, stream, static_cast<std::uint64_t>(item)).below(sources_.size())];
  }

  // Source patches are known at least in part: entirely, if there are enough such patches.
  void choose_sources() {
    const int w = source_.width;
    std::vector<int> count(pixels_in(columns_, rows_), 0);
    std::vector<int> column(w, 0);
    for (int y = 0; y < source_.height; ++y) {
      for (int x = 0; x < w; ++x) {
        column[x] += source_.known[pixel_at(x, y, w)];
        if (y >= kPatch) column[x] -= source_.known[pixel_at(x, y - kPatch, w)];
      }
      if (y < kPatch - 1) continue;
      for (int x = 0; x < columns_; ++x)
        count[static_cast<std::size_t>(y - kPatch + 1) * columns_ + x] =
            std::accumulate(column.begin() + x, column.begin() + x + kPatch, 0);
    }
    is_source_.assign(count.size(), 0);
    for (const double share : {1.0, 0.9, 0.75, 0.5, 0.3, 0.01}) {
      sources_.clear();
      const int least = std::max<int>(1, share * kPatch * kPatch);
      for (std::size_t i = 0; i < count.size(); ++i)
        if (count[i] >= least) sources_.push_back(i);
      if (sources_.size() >= kEnough) break;
    }
    for (const std::int32_t s : sources_) is_source_[s] = 1;
    whole_.assign(count.size(), 0);
    for (std::size_t i = 0; i < count.size(); ++i) whole_[i] = count[i] == kPatch * kPatch;
  }
  void choose_targets() {
    for (std::size_t i = 0; i < whole_.size(); ++i)
      if (!whole_[i]) targets_.push_back(i);
  }

  // Mean squared difference where the source is known. Known pixels of the target weigh four times as much.
  float distance(std::int32_t target, std::int32_t source, float best) const {
    const int w = source_.width;
    const std::size_t t0 = static_cast<std::size_t>(target / columns_) * w + target % columns_,
                      s0 = static_cast<std::size_t>(source / columns_) * w + source % columns_;
    float sum = 0, weight = 0;
    for (int y = 0; y < kPatch; ++y) {
      for (int x = 0; x < kPatch; ++x) {
        const std::size_t t = t0 + pixel_at(x, y, w), s = s0 + pixel_at(x, y, w);
        if (!source_.known[s]) continue;
        const float k = source_.known[t] ? 4.0f : 1.0f;
        sum += k * (picture_[t] - source_.value[s]).squaredNorm();
        weight += k;
      }
      if (sum > best * 4 * kPatch * kPatch) return std::numeric_limits<float>::max();
    }
    return weight > 0 ? sum / weight : std::numeric_limits<float>::max();
  }

  std::size_t cell_of(std::int32_t source) const {
    return pixel_at(source % columns_ / kCell, source / columns_ / kCell, columns_ / kCell + 1);
  }
  void count_uses() {
    const std::size_t cells = pixels_in(columns_ / kCell + 1, rows_ / kCell + 1);
    uses_.assign(cells, 0);
    usual_.assign(cells, 0);
    const float each = std::max(1.0F, static_cast<float>(targets_.size()) / sources_.size());
    for (const std::int32_t s : sources_) usual_[cell_of(s)] += each;
    for (const std::int32_t t : targets_) ++uses_[cell_of(match_[t])];
  }
  // A place that is used more often than others counts as that much worse (Kaspar and others 2015).
  // Otherwise the smoothest ones would be copied everywhere.
  float wear(std::int32_t source) const {
    const std::size_t cell = cell_of(source);
    return std::max(1.0F, uses_[cell] / usual_[cell]);
  }

  void search(int round, const Work& work) {
    constexpr std::size_t kBetweenChecks = 4096;
    distance_.assign(match_.size(), 0);
    for (const std::int32_t t : targets_) distance_[t] = distance(t, match_[t], 1e30f);
    count_uses();
    const bool forward = round % 2 == 0;
    const int step = forward ? -1 : 1;
    for (std::size_t n = 0; n < targets_.size(); ++n) {
      if (n % kBetweenChecks == 0) work.check();
      const std::int32_t t = targets_[forward ? n : targets_.size() - 1 - n];
      const std::size_t at = t;
      const int x = t % columns_, y = t / columns_;
      const auto offer = [&](int u, int v) {
        if (u < 0 || v < 0 || u >= columns_ || v >= rows_) return;
        const std::int32_t s = v * columns_ + u;
        if (!is_source_[s] || s == match_[at]) return;
        const float here = wear(match_[at]);
        const float there = wear(s);
        const float d = distance(t, s, distance_[at] * here / there);
        if (d * there < distance_[at] * here) {
          --uses_[cell_of(match_[at])];
          ++uses_[cell_of(s)];
          distance_[at] = d;
          match_[at] = s;
        }
      };
      for (const auto& [dx, dy] : {std::pair{step, 0}, std::pair{0, step}}) {
        const int nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= columns_ || ny >= rows_) continue;
        const auto neighbor = static_cast<std::size_t>(ny) * columns_ + nx;
        if (whole_[neighbor]) {
          offer(x, y);
          continue;
        }
        offer(match_[neighbor] % columns_ - dx, match_[neighbor] / columns_ - dy);
      }
      Random random(seed_, 16 + static_cast<std::uint64_t>(round), static_cast<std::uint64_t>(t));
      for (int radius = std::max(columns_, rows_); radius >= 1; radius /= 2) {
        const int u = match_[at] % columns_ + static_cast<int>(random.below(2 * radius + 1)) - radius,
                  v = match_[at] / columns_ + static_cast<int>(random.below(2 * radius + 1)) - radius;
        offer(u, v);
      }
      for (int tries = 0; tries < 2; ++tries) {
        const std::int32_t s = sources_[random.below(sources_.size())];
        offer(s % columns_, s / columns_);
      }
    }
  }

  // Sets unknown pixels to the weighted mean of the patches over them, or to the value of the best one.
  void vote(bool best, bool equal) {
    const int w = source_.width;
    std::vector<Vec3f> sum(picture_.size(), Vec3f::Zero());
    std::vector<float> weight(picture_.size(), 0.0f);
    float scale = 1;
    if (!equal) {
      std::vector<float> d;
      for (const std::int32_t t : targets_) d.push_back(distance_[t]);
      const auto middle = d.begin() + (d.size() * 3 / 4);
      std::nth_element(d.begin(), middle, d.end());
      scale = std::max(*middle, 1e-8f);
    }
    for (const std::int32_t t : targets_) {
      const std::int32_t m = match_[t];
      const float k = equal ? 1 : std::max(1e-6f, std::exp(-distance_[t] / (2 * scale)));
      const std::size_t t0 = static_cast<std::size_t>(t / columns_) * w + t % columns_,
                        s0 = static_cast<std::size_t>(m / columns_) * w + m % columns_;
      for (int y = 0; y < kPatch; ++y)
        for (int x = 0; x < kPatch; ++x) {
          const std::size_t a = t0 + pixel_at(x, y, w), b = s0 + pixel_at(x, y, w);
          if (source_.known[a] || !source_.known[b]) continue;
          if (!best) {
            sum[a] += k * source_.value[b];
            weight[a] += k;
            continue;
          }
          // Patches centered nearer to the pixel win among those of equal distance.
          const float near = k / (1 + 0.05f * (std::abs(x - kPatch / 2) + std::abs(y - kPatch / 2)));
          if (near > weight[a]) {
            sum[a] = source_.value[b];
            weight[a] = near;
          }
        }
    }
    for (std::size_t i = 0; i < picture_.size(); ++i)
      if (!source_.known[i] && weight[i] > 0) picture_[i] = best ? sum[i] : Vec3f(sum[i] / weight[i]);
  }

  const PartialPicture& source_;
  std::vector<Vec3f> picture_;
  int columns_, rows_;
  std::uint64_t seed_;
  std::vector<std::int32_t> sources_, targets_;
  std::vector<std::uint8_t> is_source_, whole_;
  std::vector<std::int32_t> match_;
  std::vector<float> distance_;
  std::vector<float> uses_, usual_;  // matches with sources in each cell, and on average
};

}  // namespace

void fill_picture(PartialPicture& picture, std::uint64_t seed, const Work& work) {
  if (std::find(picture.known.begin(), picture.known.end(), 0) == picture.known.end()) return;
  std::vector<PartialPicture> pyramid = {picture};
  while (std::min(pyramid.back().width, pyramid.back().height) / 2 >= kCoarsest) {
    PartialPicture next = halved(pyramid.back());
    if (std::count(next.known.begin(), next.known.end(), 1) < 64) break;
    pyramid.push_back(std::move(next));
  }
  std::vector<Level> levels;
  levels.reserve(pyramid.size());
  for (std::size_t l = pyramid.size(); l-- > 0;) {
    levels.emplace_back(pyramid[l], seed + l);
    Level& level = levels.back();
    if (levels.size() == 1)
      level.start_at_random();
    else
      level.start_from(levels[levels.size() - 2]);
    level.run(l == 0, work);
  }
  picture.value = levels.back().picture();
  std::fill(picture.known.begin(), picture.known.end(), 1);
}

}  // namespace terrazzo::detail_solid
