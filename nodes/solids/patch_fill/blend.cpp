#include "nodes/solids/patch_fill/blend.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/matching/cover.h"

namespace terrazzo::patch_fill {
namespace {

constexpr int kShifts = 4;

// wrapped() for 0 ≤ i < 2n, without a division.
int within(int i, int n) { return i < n ? i : i - n; }

// Weights of a solid's patches. Fixed patches match exactly.
std::vector<float> weights_of(const Matches& matches, const MatchLevel& level, double exponent) {
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < matches.distance.size(); ++k)
    if (level.use[k] == Use::Free) {
      sum += matches.distance[k];
      ++count;
    }
  const double floor = count > 0 && sum > 0 ? sum / count : 1;
  std::vector<float> out(matches.distance.size());
  for (std::size_t k = 0; k < out.size(); ++k)
    if (level.use[k] != Use::None) out[k] = std::pow(matches.distance[k] / floor + 1, (exponent - 2) / 2);
  return out;
}

}  // namespace

void blend(const std::array<MatchLevel, 2>& levels, const std::array<Matches, 2>& matches,
           const Torus<float>& weight, const Torus<float>& free, const BlendOptions& choice,
           Torus<Vec3f>& field, const Work& work) {
  const Vec3i n = field.size, patches = matches[0].patches;
  const std::array<std::vector<float>, 2> trust = {weights_of(matches[0], levels[0], choice.exponent),
                                                   weights_of(matches[1], levels[1], choice.exponent)};
  const auto cx = solids::patch_covers(n.x()), cy = solids::patch_covers(n.y()),
             cz = solids::patch_covers(n.z());
  const float narrow = 1 / (2 * choice.window * choice.window);
  work.parallel(static_cast<std::size_t>(n.y()) * n.z(), 4, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3f> value;
    std::vector<float> share;
    for (std::size_t row = begin; row < end; ++row) {
      const auto y = row % n.y(), z = row / n.y();
      for (std::size_t x = 0; x < static_cast<std::size_t>(n.x()); ++x) {
        const std::size_t here = row * n.x() + x;
        const float w = weight.at[here];
        if (free.at[here] <= 0) continue;
        value.clear();
        share.clear();
        for (std::size_t s = 0; s < 2; ++s) {
          const std::size_t from = value.size();
          float sum = 0;
          for (int k = 0; k < cz[z].count; ++k)
            for (int j = 0; j < cy[y].count; ++j)
              for (int i = 0; i < cx[x].count; ++i) {
                const std::size_t ui = i, uj = j, uk = k;
                const std::size_t p = voxel_at(cx[x].patch[ui], cy[y].patch[uj], cz[z].patch[uk], patches);
                const float t = trust[s][p];
                if (t <= 0) continue;
                const Place& m = matches[s].at[p];
                value.push_back(levels[s].texture.at[levels[s].texture.index(
                    within(m.x + cx[x].offset[ui], n.x()), within(m.y + cy[y].offset[uj], n.y()),
                    within(m.z + cz[z].offset[uk], n.z()))]);
                share.push_back(t);
                sum += t;
              }
          const float scale = (s == 0 ? 1 - w : w) / sum;
          for (std::size_t i = from; i < share.size(); ++i) share[i] *= scale;
        }
        Vec3f mean = Vec3f::Zero();
        for (std::size_t i = 0; i < value.size(); ++i) mean += share[i] * value[i];
        for (int shift = 0; shift < kShifts; ++shift) {
          Vec3f sum = Vec3f::Zero();
          float total = 0;
          for (std::size_t i = 0; i < value.size(); ++i) {
            // A rational kernel: unlike a Gaussian it has weight wherever the mean starts.
            const float near = 1 / (1 + narrow * (value[i] - mean).squaredNorm());
            const float f = share[i] * near * near;
            sum += f * value[i];
            total += f;
          }
          mean = sum / total;
        }
        field.at[here] = mean;
      }
    }
  });
}

}  // namespace terrazzo::patch_fill
