#include "nodes/solids/patch_fill/matches.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::patch_fill {
namespace {

constexpr int kPasses = 3;
constexpr int kUseBlock = 4;  // edge in voxels of the blocks of starts whose use is counted

Place wrapped_place(int x, int y, int z, const Vec3i& n) {
  return {static_cast<std::int16_t>(wrapped(x, n.x())), static_cast<std::int16_t>(wrapped(y, n.y())),
          static_cast<std::int16_t>(wrapped(z, n.z()))};
}

Vec3i patch_place(std::size_t k, const Vec3i& patches) {
  const int i = k;
  return Vec3i(i % patches.x(), i / patches.x() % patches.y(), i / patches.x() / patches.y());
}

// A factor ≥ 1 for each block of starts that is used more often than average.
class Overuse {
 public:
  Overuse(const Matches& matches, const MatchLevel& level, double strength)
      : blocks_((level.texture.size.array() + kUseBlock - 1) / kUseBlock), factor_(voxels_in(blocks_)) {
    double count = 0;
    for (std::size_t k = 0; k < matches.at.size(); ++k)
      if (level.use[k] == Use::Free) {
        factor_[block(matches.at[k])] += 1;
        ++count;
      }
    const double mean = count / factor_.size();
    for (float& f : factor_) f = 1 + (mean > 0 ? strength * std::max(0.0, f / mean - 1) : 0);
  }
  float of(const Place& p) const { return factor_[block(p)]; }

 private:
  std::size_t block(const Place& p) const {
    return (static_cast<std::size_t>(p.z / kUseBlock) * blocks_.y() + p.y / kUseBlock) * blocks_.x() +
           p.x / kUseBlock;
  }
  Vec3i blocks_;
  std::vector<float> factor_;
};

}  // namespace

Matches first_matches(const MatchLevel& level, std::uint64_t seed) {
  const Vec3i n = level.texture.size;
  Matches out;
  out.patches = (n.array() + 1) / 2;
  out.at.resize(level.use.size());
  out.distance.resize(level.use.size());
  for (std::size_t k = 0; k < out.at.size(); ++k) {
    const Vec3i p = level.use[k] == Use::Free
                        ? level.texture.place(Random(seed, 0x72, k).below(level.texture.at.size()))
                        : Vec3i(2 * patch_place(k, out.patches));
    out.at[k] = wrapped_place(p.x(), p.y(), p.z(), n);
  }
  return out;
}

Matches carry_up(const Matches& coarse, const Torus<Vec3f>& coarse_texture, const MatchLevel& fine) {
  const Vec3i n = fine.texture.size;
  Matches out = first_matches(fine, 0);
  for (std::size_t k = 0; k < out.at.size(); ++k) {
    if (fine.use[k] != Use::Free) continue;
    const Vec3i start = 2 * patch_place(k, out.patches);
    // The start of a coarse patch with the same center, which need not be a multiple of 2.
    int from[3], over[3];
    for (int a = 0; a < 3; ++a) {
      const int s = wrapped(start[a] / 2 - kPatch / 4, coarse_texture.size[a]);
      from[a] = std::min(s / 2, coarse.patches[a] - 1);
      over[a] = s - 2 * from[a];
    }
    const Place& m = coarse.at[voxel_at(from[0], from[1], from[2], coarse.patches)];
    out.at[k] = wrapped_place(2 * (m.x + over[0]) + kPatch / 2, 2 * (m.y + over[1]) + kPatch / 2,
                              2 * (m.z + over[2]) + kPatch / 2, n);
  }
  return out;
}

void improve(Matches& matches, const MatchLevel& level, const std::vector<float>& wanted, int dimensions,
             const SearchOptions& choice, const Work& work) {
  const Vec3i n = level.texture.size, patches = matches.patches;
  const std::size_t dims = dimensions;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Overuse overuse(matches, level, choice.overuse);
    std::vector<Place> next = matches.at;
    work.parallel(next.size(), 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        if (level.use[k] != Use::Free) continue;
        const float* query = &wanted[k * dims];
        Place best = matches.at[k];
        float score = 0, distance = 0;
        bool first = true;
        const Vec3i here = patch_place(k, patches);
        const auto at_home = [&](const Place& p) {
          const Vec3i by = Vec3i(p.x, p.y, p.z) - 2 * here;
          bool out = choice.apart > 0;
          for (int a = 0; a < 3; ++a) {
            const int d = wrapped(by[a], n[a]);
            out = out && std::min(d, n[a] - d) < choice.apart;
          }
          return out;
        };
        constexpr float kExcluded = 1e30f;
        const auto consider = [&](const Place& p) {
          const float* f = &level.features[level.texture.index(p.x, p.y, p.z) * dims];
          float d = 0;
          for (std::size_t i = 0; i < dims; ++i) d += (query[i] - f[i]) * (query[i] - f[i]);
          const float s = d * overuse.of(p) + (at_home(p) ? kExcluded : 0);
          if (first || s < score) {
            best = p;
            score = s;
            distance = d;
            first = false;
          }
        };
        consider(best);
        for (int a = 0; a < 3; ++a)
          for (const int side : {-1, 1}) {
            Vec3i other = here;
            other[a] = wrapped(here[a] + side, patches[a]);
            const std::size_t j = voxel_at(other.x(), other.y(), other.z(), patches);
            if (level.use[j] == Use::None) continue;
            Vec3i p(matches.at[j].x, matches.at[j].y, matches.at[j].z);
            p[a] -= 2 * side;
            consider(wrapped_place(p.x(), p.y(), p.z(), n));
          }
        Random random(choice.seed, static_cast<std::uint64_t>(pass), k);
        for (int reach = n.maxCoeff() / 2; reach >= 2; reach = reach * 2 / 5) {
          const auto by = [&] { return static_cast<int>(random.below(2 * reach + 1)) - reach; };
          const int dx = by(), dy = by(), dz = by();
          consider(wrapped_place(best.x + dx, best.y + dy, best.z + dz, n));
        }
        next[k] = best;
        matches.distance[k] = distance;
      }
    });
    matches.at = std::move(next);
  }
}

}  // namespace terrazzo::patch_fill
