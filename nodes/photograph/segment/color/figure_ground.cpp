#include "nodes/photograph/segment/color/figure_ground.h"

#include <algorithm>
#include <limits>

#include "graph/diagnostic.h"
#include "nodes/photograph/segment/color/pieces.h"
#include "nodes/photograph/segment/color/shading.h"
#include "nodes/photograph/segment/color/split.h"
#include "runtime/random.h"

namespace terrazzo::segment {
namespace {

constexpr int kSampleCount = 8000;
constexpr int kCoarseSide = 320;   // pixels; shapes are scored on a coarse copy
constexpr double kOrdinary = 0.6;  // neutral value of solidity × share of the outline that borders the binder

struct Coarse {
  int width, height;
  std::vector<int> cluster;
};

Coarse coarse_copy(const Mosaic& m, const Clusters& clusters) {
  std::vector<int> of_patch;
  for (const auto& c : m.colors) of_patch.push_back(clusters.nearest(c));
  const int step = std::max(1, (std::max(m.width, m.height) + kCoarseSide - 1) / kCoarseSide);
  Coarse out{std::max(1, m.width / step), std::max(1, m.height / step), {}};
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int u = std::min(x * step + step / 2, m.width - 1),
                v = std::min(y * step + step / 2, m.height - 1);
      out.cluster.push_back(of_patch[m.patches[m.index(u, v)] - 1]);
    }
  return out;
}

double score_of(const std::vector<Coarse>& sections, const std::vector<bool>& is_binder, double split,
                const Work& work) {
  double score = 0, area = 0;
  for (const auto& s : sections) {
    std::vector<std::int32_t> particles(s.cluster.size());
    for (std::size_t i = 0; i < particles.size(); ++i) particles[i] = is_binder[s.cluster[i]] ? 0 : 1;
    for (const auto& p :
         measure_pieces(split_at_necks(particles, s.width, s.height, split, work), s.width, s.height)) {
      if (p.area < 8) continue;
      const double open = p.outline / std::max(1.0, p.outline + p.contact + p.at_border);
      score += p.area * (p.solidity() * open - kOrdinary);
    }
    area += s.cluster.size();
  }
  return score / area;
}

Clusters find_clusters(const std::vector<Mosaic>& sections, int k, std::uint64_t seed, const Work& work) {
  std::vector<Vec3f> points;
  Random random(seed, 1);
  for (int i = 0; i < kSampleCount; ++i) {
    const Mosaic& m = sections[i % sections.size()];
    points.push_back(m.colors[m.patches[random.below(m.patches.size())] - 1]);
  }
  if (k > 0) return k_means(points, k, seed, work);
  std::vector<Clusters> all;
  double best = 0;
  for (int n = 2; n <= 6; ++n) {
    all.push_back(k_means(points, n, seed, work));
    best = std::max(best, all.back().silhouette);
  }
  for (std::size_t n = all.size(); n-- > 1;)
    if (all[n].silhouette >= std::max(0.9 * best, 0.75)) return all[n];
  return all[0];
}

float least_distance(const Clusters& clusters) {
  float least = std::numeric_limits<float>::max();
  for (std::size_t a = 0; a < clusters.centers.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      least = std::min(least, (clusters.centers[a] - clusters.centers[b]).norm());
  return least;
}

}  // namespace

bool even_light(std::vector<Mosaic>& sections, const Clusters& clusters, const Work& work) {
  const float apart = least_distance(clusters);
  bool changed = false;
  for (auto& m : sections) {
    const LabImage shading = shading_of(m, clusters, work);
    if (strength_of(shading) < 0.05f * apart) continue;
    take_shading_away(m, shading, work);
    changed = true;
  }
  return changed;
}

Ground find_ground(std::vector<Mosaic>& sections, int k, const Hint& hint, double split, std::uint64_t seed,
                   const Work& work) {
  Ground ground;
  ground.clusters = find_clusters(sections, k, seed, work);
  for (int round = 0; round < 2 && even_light(sections, ground.clusters, work); ++round)
    ground.clusters = find_clusters(sections, ground.clusters.centers.size(), seed, work);
  const std::size_t n = ground.clusters.centers.size();
  if (n < 2)
    throw Error("one-color", "the image has only one color, so particles cannot be separated from the binder",
                "check the image, or connect labels");
  std::vector<Coarse> coarse;
  for (const auto& m : sections) coarse.push_back(coarse_copy(m, ground.clusters));

  const auto score = [&](const std::vector<bool>& set) { return score_of(coarse, set, split, work); };
  const double none = -std::numeric_limits<double>::infinity();
  ground.score = none;
  for (std::size_t c = 0; c < n; ++c) {
    if (hint.kind == Hint::Kind::Darkest && c != 0) continue;  // clusters are sorted by lightness
    if (hint.kind == Hint::Kind::Lightest && c != n - 1) continue;
    if (hint.kind == Hint::Kind::Color && static_cast<int>(c) != ground.clusters.nearest(hint.color))
      continue;
    std::vector<bool> set(n, false);
    set[c] = true;
    if (const double s = score(set); s > ground.score) {
      ground.score = s;
      ground.is_binder = set;
    }
  }
  for (bool grown = true; grown;) {
    grown = false;
    auto best = ground.is_binder;
    for (std::size_t c = 0; c < n; ++c) {
      auto set = ground.is_binder;
      if (set[c] || std::count(set.begin(), set.end(), true) + 1 == static_cast<std::ptrdiff_t>(n)) continue;
      set[c] = true;
      if (const double s = score(set); s > ground.score) {
        ground.score = s;
        best = set;
        grown = true;
      }
    }
    ground.is_binder = best;
  }
  return ground;
}

}  // namespace terrazzo::segment
