#include <algorithm>
#include <cmath>

#include "nodes/cooccurrence/texture_nib/nib.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::texture_nib {

// Gives the dab's pixels colors of the region. Patches: so that every patch looks like one of the region.
// Colors, or a region smaller than a patch: the color of the region pixel of the same level with the most
// similar neighborhood, found among the neighbors' sources, shifted, and random ones (Ashikhmin 2001).
void Nib::restore_detail(const std::vector<std::uint32_t>& footprint, const Work& work) {
  if (dab_settings_.finish == Finish::Patches && !source_pyramid_->front().centers.empty())
    complete_patches(footprint, work);
  else
    find_colors(footprint, work);
  for (const auto p : footprint) {
    const std::size_t s = source_[p];
    picture_.pixels[p] = texture_.colors[s];
    position_[p] = texture_.positions[s];
  }
}

void Nib::complete_patches(const std::vector<std::uint32_t>& footprint, const Work& work) {
  const Rectangle hole = bounds(footprint);
  const int margin = std::min(hole.x1 - hole.x0, hole.y1 - hole.y0) + 8;
  const int x0 = std::max(0, hole.x0 - margin), y0 = std::max(0, hole.y0 - margin);
  HolePicture part;
  part.width = std::min(picture_.width, hole.x1 + margin) - x0;
  part.height = std::min(picture_.height, hole.y1 + margin) - y0;
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) {
      const std::size_t p = picture_.index(x0 + x, y0 + y);
      part.color.push_back(position_[p]);
      part.state.push_back(base_[p] == kNoLevel ? HoleState::Unknown : HoleState::Known);
    }
  const auto within = [&](std::uint32_t p) {
    const int x = static_cast<int>(p) % picture_.width - x0, y = static_cast<int>(p) / picture_.width - y0;
    return pixel_at(x, y, part.width);
  };
  for (const auto p : footprint) part.state[within(p)] = HoleState::Hole;
  const auto found = complete(*source_pyramid_, part, dab_settings_.seed, dabs_, work);
  for (const auto p : footprint) {
    source_[p] = found[within(p)];
    if (const int level = texture_.level[source_[p]]; level != base_[p]) set_level(p, level);
  }
}

void Nib::find_colors(const std::vector<std::uint32_t>& footprint, const Work& work) {
  constexpr int kReach = 2, kRounds = 4, kRandomTries = 6;
  const int w = picture_.width, h = picture_.height;
  const auto mismatch = [&](int x, int y, int sx, int sy, float limit) {
    float sum = 0;
    for (int v = -kReach; v <= kReach; ++v) {
      for (int u = -kReach; u <= kReach; ++u) {
        const int px = x + u, py = y + v, qx = sx + u, qy = sy + v;
        if (px < 0 || py < 0 || px >= w || py >= h || (u == 0 && v == 0)) continue;
        const std::size_t p = picture_.index(px, py);
        if (base_[p] == kNoLevel) continue;
        if (qx < 0 || qy < 0 || qx >= w || qy >= h) {
          sum += 0.02f;
          continue;
        }
        sum += (position_[p] - texture_.positions[picture_.index(qx, qy)]).squaredNorm();
      }
      if (sum >= limit) return sum;
    }
    return sum;
  };
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t k = 0; k < footprint.size(); ++k) {
      if (k % 256 == 0) work.check();
      const std::uint32_t p = footprint[round % 2 == 0 ? k : footprint.size() - 1 - k];
      const int x = static_cast<int>(p) % w, y = static_cast<int>(p) / w, level = base_[p];
      std::int32_t best = source_[p];
      float least = best >= 0 ? mismatch(x, y, best % w, best / w, 1e30f) : 1e30f;
      const auto try_source = [&](std::int32_t s) {
        if (s == best || texture_.level[s] != level) return;
        const float m = mismatch(x, y, s % w, s / w, least);
        if (m < least) {
          least = m;
          best = s;
        }
      };
      for (int v = -1; v <= 1; ++v)
        for (int u = -1; u <= 1; ++u) {
          if (x + u < 0 || y + v < 0 || x + u >= w || y + v >= h) continue;
          // The source of an unpainted neighbor inside the region is its own place.
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
      const auto& same = texture_.pixels_of[level];
      Random random(dab_settings_.seed, 0x91b2 + static_cast<std::uint64_t>(round), (dabs_ << 32) + p);
      for (int r = 0; r < kRandomTries; ++r)
        try_source(static_cast<std::int32_t>(same[random.below(same.size())]));
      source_[p] = best;
      position_[p] = texture_.positions[best];
    }
}

}  // namespace terrazzo::texture_nib
