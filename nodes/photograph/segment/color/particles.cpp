#include "nodes/photograph/segment/color/particles.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/common/geometry/components.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/color/bodies.h"
#include "nodes/photograph/segment/color/min_cut.h"
#include "nodes/photograph/segment/color/odd_bodies.h"
#include "nodes/photograph/segment/color/pieces.h"
#include "nodes/photograph/segment/color/split.h"
#include "nodes/photograph/segment/outline/coverage.h"

namespace terrazzo::segment {
namespace {

using Mask = std::vector<std::uint8_t>;

std::vector<std::int32_t> raster_of(const Mask& mask, bool of) {
  std::vector<std::int32_t> r(mask.size());
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = (mask[i] != 0) == of;
  return r;
}

// Calls on_pair(a, b) with the two values at every edge between pixels.
template <class Pair>
void each_edge(const std::vector<std::int32_t>& raster, int width, int height, Pair&& on_pair) {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = pixel_at(x, y, width);
      if (x + 1 < width) on_pair(raster[i], raster[i + 1]);
      if (y + 1 < height) on_pair(raster[i], raster[i + width]);
    }
}

// Fills holes smaller than min_area or a hundredth of the surrounding part.
void fill_pinholes(Mask& mask, int width, int height, double min_area) {
  const Components solid = connected_components(raster_of(mask, true), width, height, false);
  const Components gaps = connected_components(raster_of(mask, false), width, height, true);
  std::vector<std::int32_t> around(gaps.count(), 0);  // −1: more than one part, or the border
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = pixel_at(x, y, width);
      if (gaps.ids[i] == 0) continue;
      auto& a = around[gaps.ids[i] - 1];
      if (x == 0 || y == 0 || x + 1 == width || y + 1 == height) a = -1;
      auto see = [&](std::size_t j) {
        if (solid.ids[j] != 0 && a != solid.ids[j]) a = a == 0 ? solid.ids[j] : -1;
      };
      if (a != -1) see(i - 1);
      if (a != -1) see(i + 1);
      if (a != -1) see(i - width);
      if (a != -1) see(i + width);
    }
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (gaps.ids[i] == 0) continue;
    const std::int32_t a = around[gaps.ids[i] - 1];
    const double size = gaps.sizes[gaps.ids[i] - 1];
    if (a > 0 && size < std::max(min_area, 0.01 * solid.sizes[a - 1])) mask[i] = 1;
  }
}

// 12 pixels are about the smallest recognizable shape. If ever smaller parts are ever more frequent (pits,
// noise), this tail may extend to larger sizes: up to where doubling the size makes parts more frequent
// again, at most 48.
double automatic_min_area(const Components& parts) {
  double least = 12;
  for (; least < 48; least *= 2) {
    std::int64_t here = 0, above = 0;
    for (const auto size : parts.sizes) {
      const double s = size;
      here += s >= least / 2 && s < least;
      above += s >= least && s < 2 * least;
    }
    if (here <= above) break;
  }
  return least;
}

// Drops parts below min_area, and ragged parts below eight times min_area, such as cracks and rough spots.
void drop_specks(Mask& mask, const Components& parts, int width, int height, double min_area,
                 Particles2D& out) {
  const auto pieces = measure_pieces(parts.ids, width, height);
  std::vector<bool> dropped(pieces.size());
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const Piece& p = pieces[k];
    dropped[k] = p.area < min_area || (p.area < 8 * min_area && p.solidity() < 0.6);
    if (dropped[k]) {
      ++out.specks;
      out.speck_pixels += parts.sizes[k];
    }
  }
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (parts.ids[i] != 0 && dropped[parts.ids[i] - 1]) mask[i] = 0;
}

// Joins pieces smaller than min_area to the piece with the longest contact.
void join_crumbs(std::vector<std::int32_t>& labels, int width, int height, double min_area) {
  for (int round = 0; round < 3; ++round) {
    const auto pieces = measure_pieces(labels, width, height);
    std::vector<std::map<std::int32_t, int>> contacts(pieces.size());
    bool any = false;
    each_edge(labels, width, height, [&](std::int32_t a, std::int32_t b) {
      if (a == b || a == 0 || b == 0) return;
      if (pieces[a - 1].area < min_area) ++contacts[a - 1][b];
      if (pieces[b - 1].area < min_area) ++contacts[b - 1][a];
    });
    std::vector<std::int32_t> target(pieces.size());
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      target[k] = k + 1;
      int most = 0;
      for (const auto& [other, length] : contacts[k])
        if (length > most && pieces[other - 1].area >= pieces[k].area) {
          most = length;
          target[k] = other;
          any = true;
        }
    }
    for (auto& l : labels)
      if (l != 0) l = target[l - 1];
    if (!any) break;
  }
}

// Holes enclosed by a single particle become part of it, up to half its area.
std::int64_t fill_holes(std::vector<std::int32_t>& labels, int width, int height) {
  std::vector<std::int32_t> free(labels.size());
  for (std::size_t i = 0; i < free.size(); ++i) free[i] = labels[i] == 0;
  const Components gaps = connected_components(free, width, height, true);
  std::vector<std::int32_t> owner(gaps.count(), 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = pixel_at(x, y, width);
      if (gaps.ids[i] == 0) continue;
      auto& o = owner[gaps.ids[i] - 1];
      if (x == 0 || y == 0 || x + 1 == width || y + 1 == height) {
        o = -1;
        continue;
      }
      for (const std::size_t j : {i - 1, i + 1, i - width, i + width})
        if (labels[j] != 0 && o != labels[j]) o = o == 0 ? labels[j] : -1;
    }
  const auto pieces = measure_pieces(labels, width, height);
  std::int64_t filled = 0;
  for (int g = 0; g < gaps.count(); ++g) {
    if (owner[g] > 0 && gaps.sizes[g] > 0.5 * pieces[owner[g] - 1].area) owner[g] = -1;
    filled += owner[g] > 0;
  }
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (gaps.ids[i] != 0 && owner[gaps.ids[i] - 1] > 0) labels[i] = owner[gaps.ids[i] - 1];
  return filled;
}

// Distance to a cluster in units of the cluster's spread: a patch far outside a tight cluster belongs to a
// wide cluster even if the wide cluster's center is farther away. It is the square root of the deviance of
// isotropic normal clusters, shifted to be positive.
class ClusterDistance {
 public:
  explicit ClusterDistance(const Clusters& clusters) : clusters_(clusters) {
    double mean = 0;
    for (std::size_t c = 0; c < clusters.centers.size(); ++c)
      mean += clusters.weights[c] * clusters.spread[c];
    float least = 1e9f;
    for (const float s : clusters.spread) {
      spread_.push_back(std::max({s, 0.5f * static_cast<float>(mean), 1e-6f}));
      least = std::min(least, spread_.back());
    }
    for (const float s : spread_) offset_.push_back(2 * std::log(s / least));
  }
  float operator()(const Vec3f& color, std::size_t c) const {
    return std::sqrt((color - clusters_.centers[c]).squaredNorm() / (spread_[c] * spread_[c]) + offset_[c]);
  }

 private:
  const Clusters& clusters_;
  std::vector<float> spread_, offset_;
};

// Decides which patches are particles. The nearest cluster decides, but patches without an edge between them
// stay together. The color evidence grows with a patch's outline and not with its area, since errors of color
// (light, stains) are the same all over a patch. So a patch joins its neighbors' side if the share of its
// outline without an edge outweighs its color evidence.
std::vector<bool> label_patches(const Mosaic& m, const Ground& ground, const Work& work) {
  const std::size_t n = m.colors.size();
  const std::vector<float> gradient = gradient_of(m.smooth);
  auto sorted = gradient;
  const double usual = 3.1 * at_rank(sorted, sorted.size() / 4) + 1e-6;
  // Length, sum of gradients.
  std::map<std::pair<std::int32_t, std::int32_t>, std::pair<double, double>> borders;
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const std::size_t i = m.index(x, y);
      auto see = [&](std::size_t j) {
        if (m.patches[i] == m.patches[j]) return;
        auto& b = borders[std::minmax(m.patches[i], m.patches[j])];
        b.first += 1;
        b.second += std::max(gradient[i], gradient[j]);
      };
      if (x + 1 < m.width) see(i + 1);
      if (y + 1 < m.height) see(i + m.width);
    }
  std::vector<double> outline(n, 0);
  std::vector<CutEdge> edges;
  for (const auto& [pair, b] : borders) {
    outline[pair.first - 1] += b.first;
    outline[pair.second - 1] += b.first;
    edges.push_back({pair.first - 1, pair.second - 1, b.first * std::exp(-b.second / b.first / usual)});
  }
  const ClusterDistance distance(ground.clusters);
  std::vector<double> binder(n, 0), particle(n, 0);
  for (std::size_t k = 0; k < n; ++k) {
    float to_binder = 1e9f, to_particle = 1e9f;
    for (std::size_t c = 0; c < ground.is_binder.size(); ++c) {
      float& d = ground.is_binder[c] ? to_binder : to_particle;
      d = std::min(d, distance(m.colors[k], c));
    }
    const double evidence = 0.5 * outline[k] / std::max(1e-9f, to_binder + to_particle);
    binder[k] = evidence * to_binder;
    particle[k] = evidence * to_particle;
  }
  return min_cut(binder, particle, edges, work);
}

}  // namespace

Particles2D find_particles(const Mosaic& m, const Ground& ground, const SplitOptions& options,
                           const Work& work) {
  Particles2D out;
  std::vector<bool> of_patch = label_patches(m, ground, work);
  add_odd_bodies(m, ground, std::max(48.0, options.min_area), of_patch, work);
  Mask mask(m.patches.size());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = of_patch[m.patches[i] - 1];
  const auto parts_of = [&] { return connected_components(raster_of(mask, true), m.width, m.height, false); };
  out.min_area = options.min_area >= 0 ? options.min_area : automatic_min_area(parts_of());
  fill_pinholes(mask, m.width, m.height, out.min_area);
  work.check();
  out.coverage = refine_outline(m, mask, work);
  fill_pinholes(mask, m.width, m.height, out.min_area);
  drop_specks(mask, parts_of(), m.width, m.height, out.min_area, out);
  const auto bodies =
      options.strength > 0 ? color_bodies(m, mask, of_patch, out.min_area, work) : raster_of(mask, true);
  out.labels = split_at_necks(bodies, m.width, m.height, options.strength, work);
  work.check();
  join_crumbs(out.labels, m.width, m.height, out.min_area);
  renumber_labels(out.labels);
  out.holes = fill_holes(out.labels, m.width, m.height);
  return out;
}

}  // namespace terrazzo::segment
