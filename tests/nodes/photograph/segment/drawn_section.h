// Synthetic sections with known labels: angular or round particles, narrow or wide gaps, blur, mottling,
// noise, uneven light.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"
#include "runtime/random.h"

namespace terrazzo::test {

struct DrawnOptions {
  int side = 320;       // pixels
  double spacing = 34;  // of particles, pixels
  double gap = 6;       // of binder between neighbors, pixels
  double keep = 1;      // share of the lattice sites with a particle
  std::vector<Vec3f> palette = {
      {0.12f, 0.06f, 0.04f}, {0.3f, 0.12f, 0.06f}, {0.05f, 0.1f, 0.22f}, {0.02f, 0.02f, 0.02f}};
  Vec3f binder{0.62f, 0.6f, 0.55f};
  float vary = 0.08f;    // variation of the particles' brightness, relative
  float mottle = 0;      // of particles and binder, relative, over about ten pixels
  float light = 0;       // increase of light from left to right, relative
  float blur = 0.6f;     // standard deviation, pixels, in linear light
  float noise = 0.005f;  // standard deviation in encoded values
  bool signal = false;   // a micrograph: blur averages encoded values, not linear light
  std::uint64_t seed = 1;
};

struct DrawnSection {
  Image image;
  std::vector<std::int32_t> labels;
  double area_fraction = 0;  // exact, not counted in pixels
  int count = 0;
};

inline void blur_image(Image& image, float sigma) {
  if (sigma <= 0) return;
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
    const Image from = image;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        Vec3f sum = Vec3f::Zero();
        float weight = 0;
        for (int k = -reach; k <= reach; ++k) {
          const int u = x + k * dx, v = y + k * dy;
          if (u < 0 || v < 0 || u >= image.width || v >= image.height) continue;
          const float w = std::exp(-0.5f * static_cast<float>(k * k) / (sigma * sigma));
          sum += w * from.at(u, v);
          weight += w;
        }
        image.at(x, y) = sum / weight;
      }
  }
}

// Particles are the Voronoi cells of a jittered hexagonal lattice, each shrunk by half the gap.
inline DrawnSection draw_section(const DrawnOptions& o) {
  struct Site {
    double x, y;
    int label;  // 0: no particle
    Vec3f color;
  };
  std::vector<Site> sites;
  Random random(o.seed, 31);
  const double rise = o.spacing * std::sqrt(0.75);
  for (int j = -2; (j - 1) * rise < o.side; ++j)
    for (int i = -2; (i - 1) * o.spacing < o.side; ++i) {
      Site s{(i + 0.5 * (j & 1)) * o.spacing + random.uniform(-0.3, 0.3) * o.spacing,
             j * rise + random.uniform(-0.3, 0.3) * o.spacing, 0, Vec3f::Zero()};
      s.label = random.uniform() < o.keep ? static_cast<int>(sites.size()) + 1 : 0;
      s.color = o.palette[random.below(o.palette.size())] *
                static_cast<float>(1 + o.vary * std::clamp(random.normal(), -2.0, 2.0));
      sites.push_back(s);
    }
  const auto averaged = [&](const Vec3f& c) { return o.signal ? linear_to_srgb(c) : c; };
  for (auto& s : sites) s.color = averaged(s.color);
  const Vec3f binder = averaged(o.binder);
  DrawnSection out{Image(o.side, o.side, 1, 1), {}, 0, 0};
  out.labels.assign(static_cast<std::size_t>(o.side) * o.side, 0);
  constexpr int samples = 4;
  std::vector<std::size_t> near;
  for (int y = 0; y < o.side; ++y)
    for (int x = 0; x < o.side; ++x) {
      if (x % 8 == 0) {
        near.clear();
        for (std::size_t k = 0; k < sites.size(); ++k)
          if (std::hypot(sites[k].x - x - 4, sites[k].y - y) < 2 * o.spacing + 4) near.push_back(k);
      }
      Vec3f sum = Vec3f::Zero();
      std::vector<std::pair<int, int>> covered;
      for (int s = 0; s < samples * samples; ++s) {
        const double u = x + (s % samples + 0.5) / samples, v = y + (s / samples + 0.5) / samples;
        const auto square = [&](std::size_t k) {
          return (sites[k].x - u) * (sites[k].x - u) + (sites[k].y - v) * (sites[k].y - v);
        };
        std::size_t first = near[0];
        for (const auto k : near)
          if (square(k) < square(first)) first = k;
        bool inside = sites[first].label != 0;
        for (const auto k : near)
          if (k != first)
            inside = inside && (square(k) - square(first)) / (2 * std::hypot(sites[k].x - sites[first].x,
                                                                             sites[k].y - sites[first].y)) >
                                   o.gap / 2;
        sum += inside ? sites[first].color : binder;
        if (!inside) continue;
        const int label = sites[first].label;
        auto at =
            std::find_if(covered.begin(), covered.end(), [&](const auto& c) { return c.first == label; });
        if (at == covered.end()) at = covered.insert(at, {label, 0});
        ++at->second;
      }
      out.image.at(x, y) = sum / (samples * samples);
      for (const auto& [label, n] : covered) {
        out.area_fraction += n;
        if (2 * n >= samples * samples) out.labels[static_cast<std::size_t>(y) * o.side + x] = label;
      }
    }
  out.area_fraction /= static_cast<double>(samples * samples) * o.side * o.side;
  Image mottle(o.side, o.side, 1, 1);
  for (std::size_t i = 0; i < mottle.pixels.size(); ++i)
    mottle.pixels[i] = Vec3f::Constant(static_cast<float>(Random(o.seed, 32, i).normal()));
  if (o.mottle > 0) blur_image(mottle, 5);  // leaves 1 / (2·5·√π) of the deviation
  for (int y = 0; y < o.side; ++y)
    for (int x = 0; x < o.side; ++x) {
      const float m = o.mottle > 0 ? o.mottle * mottle.at(x, y)[0] * 17.7f : 0;
      out.image.at(x, y) *= std::max(0.1f, 1 + m) * (1 + o.light * (static_cast<float>(x) / o.side - 0.5f));
    }
  blur_image(out.image, o.blur);
  for (std::size_t i = 0; i < out.image.pixels.size(); ++i) {
    Random noise(o.seed, 33, i);
    Vec3f shown = o.signal ? out.image.pixels[i] : linear_to_srgb(out.image.pixels[i]);
    const bool gray = (o.binder.array() == o.binder[0]).all();
    float n = static_cast<float>(noise.normal());
    for (int k = 0; k < 3; ++k) {
      shown[k] = std::clamp(shown[k] + o.noise * n, 0.0f, 1.0f);
      if (!gray) n = static_cast<float>(noise.normal());
    }
    out.image.pixels[i] = srgb_to_linear(shown);
  }
  std::map<int, int> sizes;
  for (const auto l : out.labels)
    if (l != 0) ++sizes[l];
  for (const auto& [label, n] : sizes) out.count += n >= 12;
  return out;
}

// Average precision TP / (TP + FP + FN), for matches with an intersection over union above ½. True particles
// of fewer than 12 pixels do not count.
inline double average_precision(const std::vector<std::int32_t>& truth,
                                const std::vector<std::int32_t>& found) {
  std::map<std::pair<int, int>, int> joint;
  std::map<int, int> a, b;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i]) ++a[truth[i]];
    if (found[i]) ++b[found[i]];
    if (truth[i] && found[i]) ++joint[{truth[i], found[i]}];
  }
  int matches = 0, drawn = 0;
  for (const auto& [pair, n] : joint)
    matches += a[pair.first] >= 12 && 2 * n > a[pair.first] + b[pair.second] - n;
  for (const auto& [label, n] : a) drawn += n >= 12;
  return matches / std::max(1.0, static_cast<double>(drawn) + static_cast<double>(b.size()) - matches);
}

}  // namespace terrazzo::test
