#include "nodes/cooccurrence/texture_nib/completion.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::texture_nib {
namespace {

constexpr int kReach = 3, kSide = 2 * kReach + 1;
constexpr std::size_t kFew = 200;       // centers that a level must have
constexpr float kReuse = 0.5f;          // relative cost added to a source by each patch that uses it
constexpr std::size_t kValues = 16384;  // most values of the region sampled for its distribution

// Counts the patches that use each source, in a hash table so that cost depends on the size of the hole, not
// of the picture.
class UseCount {
 public:
  int count(std::int32_t source) const {
    for (std::size_t i = slot(source);; i = (i + 1) & (entry_.size() - 1)) {
      if (entry_[i].source == source) return entry_[i].count;
      if (entry_[i].source < 0) return 0;
    }
  }
  void add(std::int32_t source, int by) {
    for (std::size_t i = slot(source);; i = (i + 1) & (entry_.size() - 1)) {
      if (entry_[i].source == source) {
        entry_[i].count += by;
        return;
      }
      if (entry_[i].source >= 0) continue;
      entry_[i] = {source, by};
      if (2 * ++filled_ > entry_.size()) grow();
      return;
    }
  }

 private:
  struct Entry {
    std::int32_t source = -1, count = 0;
  };
  std::size_t slot(std::int32_t source) const { return mix64(source) & (entry_.size() - 1); }
  // Drops entries that are no longer in use.
  void grow() {
    std::vector<Entry> old(2 * entry_.size());
    old.swap(entry_);
    filled_ = 0;
    for (const Entry& e : old)
      if (e.source >= 0 && e.count != 0) add(e.source, e.count);
  }
  std::vector<Entry> entry_ = std::vector<Entry>(256);
  std::size_t filled_ = 0;
};

SourceLevel halved(const SourceLevel& in) {
  SourceLevel out;
  out.width = in.width / 2;
  out.height = in.height / 2;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(2 * y) * in.width + 2 * x, below = i + in.width;
      out.color.push_back((in.color[i] + in.color[i + 1] + in.color[below] + in.color[below + 1]) / 4);
      out.inside.push_back(in.inside[i] && in.inside[i + 1] && in.inside[below] && in.inside[below + 1]);
    }
  return out;
}

void prepare(SourceLevel& s) {
  const int w = s.width, h = s.height;
  for (int y = kReach; y < h - kReach; ++y)
    for (int x = kReach; x < w - kReach; ++x) {
      bool whole = true;
      for (int v = -kReach; v <= kReach && whole; ++v)
        for (int u = -kReach; u <= kReach && whole; ++u) whole = s.inside[(y + v) * w + x + u] != 0;
      if (whole) s.centers.push_back(y * w + x);
    }
  s.usable.assign(s.color.size(), 0);
  for (const auto c : s.centers) s.usable[c] = 1;
  // Values of the region, evenly sampled.
  std::vector<std::size_t> region;
  for (std::size_t i = 0; i < s.inside.size(); ++i)
    if (s.inside[i]) region.push_back(i);
  const std::size_t n = std::min(region.size(), kValues);
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < n; ++i) s.values[c].push_back(s.color[region[i * region.size() / n]][c]);
    std::sort(s.values[c].begin(), s.values[c].end());
  }
}

HolePicture halved(const HolePicture& in) {
  HolePicture out;
  out.width = (in.width + 1) / 2;
  out.height = (in.height + 1) / 2;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      Vec3f sum = Vec3f::Zero();
      int known = 0, hole = 0, all = 0;
      for (int v = 2 * y; v < std::min(2 * y + 2, in.height); ++v)
        for (int u = 2 * x; u < std::min(2 * x + 2, in.width); ++u, ++all) {
          const std::size_t i = pixel_at(u, v, in.width);
          known += in.state[i] == HoleState::Known;
          hole += in.state[i] == HoleState::Hole;
          sum += in.color[i];
        }
      out.color.push_back(sum / float(all));
      out.state.push_back(hole > 0 ? HoleState::Hole : known == all ? HoleState::Known : HoleState::Unknown);
    }
  return out;
}

// Steps from the hole's edge: 1 at the rim, 0 outside.
std::vector<int> depth_of(const HolePicture& t) {
  std::vector<int> depth(t.state.size(), 0);
  std::vector<std::size_t> ring, next;
  const auto beside = [&](std::size_t i, auto&& visit) {
    const int x = static_cast<int>(i) % t.width, y = static_cast<int>(i) / t.width;
    for (int v = std::max(0, y - 1); v <= std::min(t.height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(t.width - 1, x + 1); ++u) visit(pixel_at(u, v, t.width));
  };
  for (std::size_t i = 0; i < t.state.size(); ++i) {
    if (t.state[i] != HoleState::Hole) continue;
    bool rim = false;
    beside(i, [&](std::size_t q) { rim |= t.state[q] == HoleState::Known; });
    if (rim) {
      ring.push_back(i);
      depth[i] = 1;
    }
  }
  for (int d = 2; !ring.empty(); ++d, ring.swap(next)) {
    next.clear();
    for (const auto i : ring)
      beside(i, [&](std::size_t q) {
        if (t.state[q] == HoleState::Hole && depth[q] == 0) {
          depth[q] = d;
          next.push_back(q);
        }
      });
  }
  int deepest = 1;
  for (const int d : depth) deepest = std::max(deepest, d);
  for (std::size_t i = 0; i < depth.size(); ++i)  // not reachable from known pixels
    if (t.state[i] == HoleState::Hole && depth[i] == 0) depth[i] = deepest + 1;
  return depth;
}

// One level: the target's patches and their best matches in the source.
class Filler {
 public:
  Filler(const SourceLevel& source, HolePicture& target, std::uint64_t seed, std::uint64_t stream,
         const Work& work)
      : s_(source), t_(target), seed_(seed), stream_(stream), work_(work), depth_(depth_of(target)) {
    known_.assign(t_.state.size(), 0);
    match_.assign(t_.state.size(), -1);
    distance_.assign(t_.state.size(), 0);
    // Find the patches that overlap the hole.
    std::vector<std::uint8_t> near(t_.state.size(), 0);
    for (int y = 0; y < t_.height; ++y)
      for (int x = 0; x < t_.width; ++x)
        if (t_.state[at(x, y)] == HoleState::Hole)
          for (int v = std::max(0, y - kReach); v <= std::min(t_.height - 1, y + kReach); ++v)
            for (int u = std::max(0, x - kReach); u <= std::min(t_.width - 1, x + kReach); ++u)
              near[at(u, v)] = 1;
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (near[i]) patches_.push_back(i);
      known_[i] = t_.state[i] == HoleState::Known;
    }
  }

  // Fills from the rim inwards, each pixel from the known pixels around it.
  void peel(int tries) {
    std::vector<std::size_t> order = patches_;
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return depth_[a] < depth_[b]; });
    for (std::size_t k = 0; k < order.size(); ++k) {
      check(k);
      const auto p = order[k];
      search(p, 0, tries);
      if (t_.state[p] == HoleState::Hole) {
        t_.color[p] = s_.color[match_[p]];
        known_[p] = 1;
      }
    }
  }
  // Starts from the next coarser level's matches, so that means continue from there.
  void take(const Filler& coarse) {
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      check(k);
      const auto p = patches_[k];
      const int x = static_cast<int>(p) % t_.width, y = static_cast<int>(p) / t_.width;
      const std::int32_t m =
          coarse
              .match_[coarse.at(std::min(x / 2, coarse.t_.width - 1), std::min(y / 2, coarse.t_.height - 1))];
      if (m < 0) continue;
      const int sx = m % coarse.s_.width * 2 + x % 2, sy = m / coarse.s_.width * 2 + y % 2;
      assign(p, nearest_usable(sx, sy));
    }
    for (const auto p : patches_) {
      if (match_[p] < 0) assign(p, random_center(p, 99));
      if (t_.state[p] == HoleState::Hole) known_[p] = 1;
    }
    vote(true);
  }

  void sweep(int round, int tries) {
    measure();
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      check(k);
      search(patches_[round % 2 ? patches_.size() - 1 - k : k], round, tries);
    }
  }

  // Sets every hole pixel to the mean of the source pixels that the patches over it propose. Better matches
  // and patches nearer to the rim have more weight. If not `mean`, sets it to the proposed pixel nearest to
  // that mean.
  void vote(bool mean) {
    measure();
    std::vector<float> sorted;
    for (const auto p : patches_) sorted.push_back(distance_[p]);
    const float scale = 1 / std::max(1e-7f, at_rank(sorted, 3 * (sorted.size() - 1) / 4));
    std::vector<float> weight(t_.state.size(), 0);
    for (const auto p : patches_)
      weight[p] = std::exp(-distance_[p] * scale) * std::pow(1.3f, -float(depth_[p])) + 1e-12f;
    std::vector<Vec3f> now = t_.color;
    if (!mean) chosen_.assign(t_.state.size(), -1);
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      check(k);
      const auto p = patches_[k];
      if (t_.state[p] != HoleState::Hole) continue;
      const int x = static_cast<int>(p) % t_.width, y = static_cast<int>(p) / t_.width;
      Vec3f sum = Vec3f::Zero();
      float total = 0;
      const auto each = [&](auto&& visit) {
        for (int v = std::max(0, y - kReach); v <= std::min(t_.height - 1, y + kReach); ++v)
          for (int u = std::max(0, x - kReach); u <= std::min(t_.width - 1, x + kReach); ++u) {
            const std::size_t q = at(u, v);
            const int from = match_[q] + (y - v) * s_.width + x - u;
            visit(q, from, weight[q]);
          }
      };
      each([&](std::size_t, int from, float w) {
        sum += w * s_.color[from];
        total += w;
      });
      const Vec3f middle = sum / total;
      now[p] = middle;
      if (mean) continue;
      float least = 1e30f;
      each([&](std::size_t q, int from, float w) {
        const float d = (s_.color[from] - middle).squaredNorm() + (q == p ? 0 : 1e-9f);
        if (w > 0 && d < least) {
          least = d;
          chosen_[p] = from;
          now[p] = s_.color[from];
        }
      });
    }
    t_.color = std::move(now);
    if (mean) spread();
  }

  // Matches the hole to the region's distribution of each channel, because means of patches lose rare values.
  void spread() {
    std::vector<std::size_t> order;
    for (const auto p : patches_)
      if (t_.state[p] == HoleState::Hole) order.push_back(p);
    for (int c = 0; c < 3; ++c) {
      const auto& values = s_.values[c];
      std::stable_sort(order.begin(), order.end(),
                       [&](auto a, auto b) { return t_.color[a][c] < t_.color[b][c]; });
      for (std::size_t i = 0; i < order.size(); ++i)
        t_.color[order[i]][c] = values[(2 * i + 1) * values.size() / (2 * order.size())];
    }
  }
  const std::vector<std::int32_t>& chosen() const { return chosen_; }

 private:
  // Checks for cancellation. A stroke may fill a whole picture, and one sweep over it takes seconds.
  void check(std::size_t k) const {
    if (k % 256 == 0) work_.check();
  }
  std::size_t at(int x, int y) const { return pixel_at(x, y, t_.width); }
  std::int32_t random_center(std::size_t p, int round) const {
    Random r(seed_, stream_ + round, p);
    return s_.centers[r.below(s_.centers.size())];
  }
  std::int32_t nearest_usable(int x, int y) const {
    x = std::clamp(x, kReach, s_.width - 1 - kReach);
    y = std::clamp(y, kReach, s_.height - 1 - kReach);
    for (int r = 0; r <= 3; ++r)
      for (int v = -r; v <= r; ++v)
        for (int u = -r; u <= r; ++u) {
          if (std::max(std::abs(u), std::abs(v)) != r) continue;
          const int a = x + u, b = y + v;
          if (a >= 0 && b >= 0 && a < s_.width && b < s_.height && s_.usable[b * s_.width + a])
            return b * s_.width + a;
        }
    return -1;
  }
  void assign(std::size_t p, std::int32_t to) {
    if (match_[p] >= 0) used_.add(match_[p], -1);
    match_[p] = to;
    if (to >= 0) used_.add(to, 1);
  }
  void measure() {
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      check(k);
      const auto p = patches_[k];
      if (match_[p] >= 0) distance_[p] = mismatch(p, match_[p], 1e30f);
    }
  }

  // Mean squared difference over the known pixels of the patch.
  float mismatch(std::size_t p, std::int32_t m, float limit) const {
    const int x = static_cast<int>(p) % t_.width, y = static_cast<int>(p) / t_.width;
    const int u0 = std::max(-kReach, -x), u1 = std::min(kReach, t_.width - 1 - x);
    float sum = 0;
    int n = 0;
    for (int v = std::max(-kReach, -y); v <= std::min(kReach, t_.height - 1 - y); ++v) {
      const std::size_t row = at(x, y + v);
      const Vec3f* source = &s_.color[m + v * s_.width];
      for (int u = u0; u <= u1; ++u) {
        if (!known_[row + u]) continue;
        ++n;
        sum += (t_.color[row + u] - source[u]).squaredNorm();
      }
      if (sum > limit * (kSide * kSide)) return sum;
    }
    return n > 0 ? sum / float(n) : 0;
  }
  float price(std::size_t p, std::int32_t m, float limit) const {
    const float more = 1 + kReuse * float(used_.count(m) - (match_[p] == m));
    return (mismatch(p, m, limit / more) + 1e-5f) * more;
  }

  void search(std::size_t p, int round, int tries) {
    const int x = static_cast<int>(p) % t_.width, y = static_cast<int>(p) / t_.width;
    std::int32_t best = match_[p];
    float least = best >= 0 ? price(p, best, 1e30f) : 1e30f;
    const auto attempt = [&](std::int32_t m) {
      if (m == best) return;
      const float d = price(p, m, least);
      if (d < least) {
        least = d;
        best = m;
      }
    };
    for (int v = -1; v <= 1; ++v)
      for (int u = -1; u <= 1; ++u) {
        if (x + u < 0 || y + v < 0 || x + u >= t_.width || y + v >= t_.height) continue;
        const std::int32_t m = match_[at(x + u, y + v)];
        if (m < 0) continue;
        const int sx = m % s_.width - u, sy = m / s_.width - v;
        if (sx >= kReach && sy >= kReach && sx < s_.width - kReach && sy < s_.height - kReach &&
            s_.usable[sy * s_.width + sx])
          attempt(sy * s_.width + sx);
      }
    Random r(seed_, stream_ + 0x100 * static_cast<std::uint64_t>(round + 1), p);
    for (int k = 0; k < tries; ++k)
      attempt(static_cast<std::int32_t>(s_.centers[r.below(s_.centers.size())]));
    for (int reach = std::max(s_.width, s_.height) / 4; reach >= 1; reach /= 2) {
      const int sx = best % s_.width + static_cast<int>(r.below(2 * reach + 1)) - reach;
      const int sy = best / s_.width + static_cast<int>(r.below(2 * reach + 1)) - reach;
      if (sx >= 0 && sy >= 0 && sx < s_.width && sy < s_.height && s_.usable[sy * s_.width + sx])
        attempt(sy * s_.width + sx);
    }
    if (best != match_[p]) assign(p, best);
  }

  const SourceLevel& s_;
  HolePicture& t_;
  std::uint64_t seed_, stream_;
  Work work_;
  std::vector<int> depth_;
  std::vector<std::uint8_t> known_;
  std::vector<std::int32_t> match_, chosen_;
  UseCount used_;
  std::vector<float> distance_;
  std::vector<std::size_t> patches_;
};

}  // namespace

SourcePyramid source_pyramid(int width, int height, const std::vector<Vec3f>& color,
                             const std::vector<std::uint8_t>& inside) {
  SourcePyramid out(1);
  out[0].width = width;
  out[0].height = height;
  out[0].color = color;
  out[0].inside = inside;
  prepare(out[0]);
  while (out.back().width >= 2 * kSide && out.back().height >= 2 * kSide) {
    SourceLevel next = halved(out.back());
    prepare(next);
    if (next.centers.size() < kFew) break;
    out.push_back(std::move(next));
  }
  return out;
}

std::vector<std::int32_t> complete(const SourcePyramid& source, HolePicture picture, std::uint64_t seed,
                                   std::uint64_t item, const Work& work) {
  std::vector<std::int32_t> none(picture.state.size(), -1);
  if (source[0].centers.empty()) return none;
  std::vector<HolePicture> target{std::move(picture)};
  for (;;) {
    const auto depth = depth_of(target.back());
    if (target.size() >= source.size() || *std::max_element(depth.begin(), depth.end()) <= 4) break;
    target.push_back(halved(target.back()));
  }
  std::unique_ptr<Filler> before;
  for (std::size_t level = target.size(); level-- > 0;) {
    const auto stream = [&](int k) { return mix64(0x6c6f6f6b + item * 64 + level * 8 + k); };
    const bool coarsest = level + 1 == target.size();
    std::unique_ptr<Filler> now;
    if (coarsest) {
      now = std::make_unique<Filler>(source[level], target[level], seed, stream(0), work);
      now->peel(40);
      now->vote(true);
    } else {
      now = std::make_unique<Filler>(source[level], target[level], seed, stream(0), work);
      now->take(*before);
    }
    const int rounds = coarsest ? 8 : 6;
    for (int round = 0; round < rounds; ++round) {
      now->sweep(round, 4);
      now->vote(!(level == 0 && round + 1 == rounds));
    }
    before = std::move(now);
  }
  return before->chosen();
}

}  // namespace terrazzo::texture_nib
