#include <algorithm>
#include <cmath>

#include "nodes/texture_nib/nib.h"
#include "runtime/random.h"

namespace terrazzo::texture_nib {
namespace {

// The dab's pixels from its edge inwards: each time those beside a pixel that says something. What nothing
// leads to comes last.
std::vector<std::uint32_t> inwards(const std::vector<std::uint32_t>& footprint,
                                   std::vector<std::uint8_t>& known, int width, int height) {
  std::vector<std::uint8_t> wanted(known.size(), 0);
  for (const auto p : footprint) wanted[p] = 1;
  std::vector<std::uint8_t> reached = known;
  std::vector<std::uint32_t> order, ring, next;
  const auto beside = [&](std::uint32_t p, auto&& visit) {
    const int x = static_cast<int>(p) % width, y = static_cast<int>(p) / width;
    for (int v = -1; v <= 1; ++v)
      for (int u = -1; u <= 1; ++u)
        if (x + u >= 0 && y + v >= 0 && x + u < width && y + v < height)
          visit(static_cast<std::uint32_t>((y + v) * width + x + u));
  };
  for (const auto p : footprint) {
    bool edge = false;
    beside(p, [&](std::uint32_t q) { edge |= reached[q] && !wanted[q]; });
    if (edge) ring.push_back(p);
  }
  for (const auto p : ring) wanted[p] = 0;
  while (!ring.empty()) {
    next.clear();
    for (const auto p : ring) {
      order.push_back(p);
      beside(p, [&](std::uint32_t q) {
        if (wanted[q]) wanted[q] = 0, next.push_back(q);
      });
    }
    std::sort(next.begin(), next.end());
    ring.swap(next);
  }
  for (const auto p : footprint)
    if (wanted[p]) order.push_back(p);
  return order;
}

}  // namespace

// Gives the dab's pixels colours of the region: those of the pixel there whose surroundings look most alike,
// found among the sources of the neighbours, shifted, and random ones (Ashikhmin 2001, Barnes 2009). Alone
// that favours what is smooth; so where the level may change, a source counts the more the more its level is
// overused beside these neighbours, by the matrix.
void Nib::restore_detail(const std::vector<std::uint32_t>& footprint, const Work& work) {
  const bool patches = manner_.finish == Finish::Patches;
  const int reach = patches ? 4 : 2, rounds = 4, random_tries = patches ? 24 : 6;
  const int w = picture_.width, h = picture_.height;
  // Colours that say something: painted, or near enough to the texture's.
  std::vector<std::uint8_t> known(occupied_.size());
  for (std::size_t i = 0; i < known.size(); ++i) known[i] = base_[i] != kNoLevel;
  std::vector<std::uint32_t> order = footprint;
  if (patches) {
    order = inwards(footprint, known, w, h);
    for (const auto p : footprint) known[p] = 0;
  }
  const auto mismatch = [&](int x, int y, int sx, int sy, float limit) {
    float sum = 0;
    int n = 0;
    for (int v = -reach; v <= reach; ++v) {
      for (int u = -reach; u <= reach; ++u) {
        const int px = x + u, py = y + v, qx = sx + u, qy = sy + v;
        if (px < 0 || py < 0 || px >= w || py >= h || (u == 0 && v == 0)) continue;
        const std::size_t p = picture_.index(px, py);
        if (!known[p]) continue;
        ++n;
        if (qx < 0 || qy < 0 || qx >= w || qy >= h) {
          sum += 0.02f;
          continue;
        }
        sum += (position_[p] - texture_.positions[picture_.index(qx, qy)]).squaredNorm();
      }
      if (sum >= limit) return sum;
    }
    return n > 0 ? sum : 0.0f;
  };
  std::vector<float> use;
  for (int round = 0; round < rounds; ++round)
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (k % 256 == 0) work.check();
      const std::uint32_t p = order[patches || round % 2 == 0 ? k : order.size() - 1 - k];
      const int x = static_cast<int>(p) % w, y = static_cast<int>(p) / w, level = base_[p];
      std::int32_t best = source_[p];
      if (patches) {
        overuse(p, use);
        for (auto& u : use) u *= std::sqrt(u);
      } else {
        use.assign(static_cast<std::size_t>(texture_.levels.count()), 1.0f);
      }
      float least = best >= 0 ? use[texture_.level[best]] * mismatch(x, y, best % w, best / w, 1e30f) : 1e30f;
      const auto try_source = [&](std::int32_t s) {
        const auto at = texture_.level[static_cast<std::size_t>(s)];
        if (s == best || at == kNoLevel || (!patches && at != level)) return;
        const float m = use[at] * mismatch(x, y, s % w, s / w, least / use[at]);
        if (m < least) least = m, best = s;
      };
      for (int v = -1; v <= 1; ++v)
        for (int u = -1; u <= 1; ++u) {
          if (x + u < 0 || y + v < 0 || x + u >= w || y + v >= h) continue;
          // Of an unpainted neighbour inside the region its own place is the source.
          const std::size_t q = picture_.index(x + u, y + v);
          const std::int32_t s = source_[q] >= 0 ? source_[q]
                                 : !occupied_[q] && texture_.level[q] != kNoLevel
                                     ? static_cast<std::int32_t>(q)
                                     : -1;
          if (s < 0) continue;
          const int sx = s % w - u, sy = s / w - v;
          if (sx < 0 || sy < 0 || sx >= w || sy >= h || (sx == x && sy == y)) continue;
          try_source(sy * w + sx);
        }
      const auto& same = texture_.pixels_of[static_cast<std::size_t>(level)];
      Random random(manner_.seed, 0x91b2 + static_cast<std::uint64_t>(round), (dabs_ << 32) + p);
      for (int r = 0; r < random_tries; ++r)
        try_source(static_cast<std::int32_t>(same[random.below(same.size())]));
      source_[p] = best;
      position_[p] = texture_.positions[static_cast<std::size_t>(best)];
      known[p] = 1;
      if (texture_.level[best] != base_[p]) set_level(p, texture_.level[best]);
    }
  for (const auto p : footprint) {
    const auto s = static_cast<std::size_t>(source_[p]);
    picture_.pixels[p] = texture_.colors[s];
  }
}

}  // namespace terrazzo::texture_nib
