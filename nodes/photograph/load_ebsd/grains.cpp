#include "nodes/photograph/load_ebsd/grains.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::load_ebsd {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Calls f with each of the four neighbors of pixel i.
template <class F>
void neighbors(const EbsdMap& map, std::size_t i, F&& f) {
  const std::size_t width = map.width;
  const std::size_t x = i % width, y = i / width;
  if (y > 0) f(i - width);
  if (x > 0) f(i - 1);
  if (x + 1 < width) f(i + 1);
  if (y + 1 < static_cast<std::size_t>(map.height)) f(i + width);
}

// The phase of each point that takes part, −1 for the others.
std::vector<std::int32_t> phases_of(const EbsdMap& map, const GrainRule& rule) {
  std::vector<bool> wanted(map.phases.size(), rule.phases.empty());
  for (const auto p : rule.phases) {
    if (p < 1 || p > static_cast<std::int64_t>(map.phases.size()))
      throw Error("bad-value", fmt::format("there is no phase {}; the map has {}", p, map.phases.size()))
          .parameter("phases");
    wanted[p - 1] = true;
  }
  std::vector<std::int32_t> out(map.points.size(), -1);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const MapPoint& p = map.points[i];
    if (p.phase >= 0 && wanted[p.phase] && p.confidence >= rule.min_confidence &&
        p.deviation <= rule.max_deviation)
      out[i] = p.phase;
  }
  return out;
}

// Pixels without a grain next to one join the grain that most of their neighbors have, the first of several.
void fill_once(const EbsdMap& map, std::vector<std::int32_t>& ids) {
  const std::vector<std::int32_t> before = ids;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (before[i] != 0) continue;
    std::array<std::int32_t, 4> near{};  // 0 also outside of the map
    std::size_t count = 0;
    neighbors(map, i, [&](std::size_t n) { near[count++] = before[n]; });
    std::sort(near.begin(), near.end());
    std::ptrdiff_t most = 0;
    for (const std::int32_t id : near) {
      const auto same = std::count(near.begin(), near.end(), id);
      if (id != 0 && same > most) {
        most = same;
        ids[i] = id;
      }
    }
  }
}

// Mean orientation and spread, of the pixels that were measured.
void measure(const EbsdMap& map, const std::vector<std::int32_t>& ids,
             const std::vector<std::vector<Eigen::Quaternionf>>& rotations, std::vector<Grain>& grains) {
  // Twice: equivalents close to the grain's first orientation, then close to that mean.
  std::vector<Eigen::Vector4d> sums;
  for (int pass = 0; pass < 2; ++pass) {
    sums.assign(grains.size(), Eigen::Vector4d::Zero());
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] == 0) continue;
      const std::size_t g = ids[i] - 1;
      const auto& symmetry = rotations[grains[g].phase];
      sums[g] += closest(map.points[i].orientation, grains[g].mean, symmetry).coeffs().cast<double>();
    }
    for (std::size_t g = 0; g < grains.size(); ++g)
      grains[g].mean = Eigen::Quaternionf(sums[g].normalized().cast<float>().eval());
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] == 0) continue;
    Grain& g = grains[ids[i] - 1];
    const float cosine = half_angle_cosine(map.points[i].orientation, g.mean, rotations[g.phase]);
    const double n = g.pixels;
    g.spread += 2 * std::acos(std::min<double>(1.0, cosine)) / kDegree / n;
    g.quality += map.points[i].quality / n;
  }
}

}  // namespace

Grains find_grains(const EbsdMap& map, const GrainRule& rule, const Work& work) {
  const std::vector<std::int32_t> phase = phases_of(map, rule);
  std::vector<std::vector<Eigen::Quaternionf>> rotations;
  for (const auto& p : map.phases) rotations.push_back(p.symmetry.rotations());
  const float limit = std::cos(rule.misorientation * kDegree / 2);
  DisjointSets sets(map.points.size());
  const std::size_t width = map.width;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    if (i % 4096 == 0) {
      work.check();
      work.progress(static_cast<double>(i) / map.points.size(), "grains");
    }
    if (phase[i] < 0) continue;
    const auto join = [&](std::size_t n) {
      if (phase[n] == phase[i] && half_angle_cosine(map.points[i].orientation, map.points[n].orientation,
                                                    rotations[phase[i]]) > limit)
        sets.join(i, n);
    };
    if (i % width > 0) join(i - 1);
    if (i >= width) join(i - width);
  }
  std::vector<std::int64_t> pixels(map.points.size());
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (phase[i] >= 0) ++pixels[sets.find(i)];

  Grains out;
  Labels& labels = out.labels;
  labels.width = map.width;
  labels.height = map.height;
  labels.pixel_size = map.pixel_size / 1000;
  labels.ids.assign(map.points.size(), 0);
  std::vector<std::int32_t> number(map.points.size());
  for (std::size_t i = 0; i < map.points.size(); ++i) {  // the representative of a set is its first pixel
    if (phase[i] < 0) continue;
    const std::size_t root = sets.find(i);
    if (pixels[root] < rule.min_pixels) continue;
    if (root == i) {
      out.grains.push_back({phase[i], pixels[i], map.points[i].orientation});
      labels.classes.push_back(phase[i]);
      number[i] = out.grains.size();
    }
    labels.ids[i] = number[root];
  }
  if (out.grains.empty())
    throw Error("no-particles", "the map has no grain with these settings",
                "lower min_confidence and min_pixels, raise max_deviation, or choose other phases");
  measure(map, labels.ids, rotations, out.grains);
  for (int k = 0; k < rule.fill; ++k) {
    work.check();
    fill_once(map, labels.ids);
  }
  return out;
}

Table grain_table(const EbsdMap& map, const Grains& g) {
  Table out;
  out.columns = {"grain",  "phase", "pixels", "area mm²", "diameter mm",
                 "phi1 °", "Phi °", "phi2 °", "spread °", "quality"};
  std::vector<std::int64_t> pixels(g.grains.size());
  for (const auto id : g.labels.ids)
    if (id > 0) ++pixels[id - 1];
  for (std::size_t k = 0; k < g.grains.size(); ++k) {
    const Grain& grain = g.grains[k];
    const double area = pixels[k] * g.labels.pixel_size * g.labels.pixel_size;
    const Vec3 angles = to_bunge(grain.mean);
    out.rows.push_back({static_cast<double>(k + 1), map.phases[grain.phase].name,
                        static_cast<double>(pixels[k]), area, std::sqrt(4 * area / std::numbers::pi),
                        angles.x(), angles.y(), angles.z(), grain.spread, grain.quality});
  }
  return out;
}

Image orientation_image(const EbsdMap& map, const Work& work) {
  Image out(map.width, map.height, 1, map.pixel_size / 1000);
  work.parallel(out.pixels.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const MapPoint& p = map.points[i];
      if (p.phase < 0) continue;
      out.pixels[i] = srgb_to_linear(direction_color(p.orientation, map.phases[p.phase].symmetry));
    }
  });
  return out;
}

Image quality_image(const EbsdMap& map) {
  Image out(map.width, map.height, 1, map.pixel_size / 1000);
  float most = 0;
  for (const auto& p : map.points) most = std::max(most, p.quality);
  for (std::size_t i = 0; i < out.pixels.size(); ++i)
    if (most > 0)
      out.pixels[i] = srgb_to_linear(Vec3f::Constant(std::max(0.0f, map.points[i].quality) / most));
  return out;
}

}  // namespace terrazzo::load_ebsd
