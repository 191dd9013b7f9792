#include "nodes/shape_estimate/section_sample.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "nodes/common/stereology/random_sections.h"

namespace terrazzo::shape_estimate {

FeatureSample sample_sections(const Mesh& mesh, std::size_t planes, const OutlineMeasuring& measuring,
                              std::size_t first) {
  FeatureSample out;
  for (std::size_t i = 0; i < planes; ++i) {
    const auto k = static_cast<double>(first + i + 1);
    const auto part = [&](double step) { return std::fmod(0.5 + step * k, 1.0); };
    const double z = part(0.8191725133961645), phi = 2 * std::numbers::pi * part(0.6710436067037893),
                 depth = part(0.5497004779019703), r = std::sqrt(1 - z * z);
    const Vec3 u(r * std::cos(phi), r * std::sin(phi), z);
    double low = 1e300, high = -1e300;
    for (const Vec3& v : mesh.vertices) {
      const double h = u.dot(v);
      low = std::min(low, h), high = std::max(high, h);
    }
    for (const auto& profile :
         section_profiles(section_loops(mesh, frame_about(u), low + depth * (high - low)))) {
      const OutlineFeatures f = outline_features(profile[0], measuring);
      if (f[OutlineFeature::Circularity] <= 0) continue;
      out.features.push_back(f);
      out.root_area.push_back(std::sqrt(loop_area(profile[0])));
      out.weight.push_back(high - low);
    }
  }
  return out;
}

double total_weight(const FeatureSample& s) { return std::accumulate(s.weight.begin(), s.weight.end(), 0.0); }

void drop_small(FeatureSample& s, double smallest) {
  if (smallest <= 0 || s.features.empty()) return;
  std::vector<std::size_t> order(s.features.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) {
    return s.root_area[a] > s.root_area[b] || (s.root_area[a] == s.root_area[b] && a < b);
  });
  double above = 0;
  const double tenth = total_weight(s) / 10;
  double large = s.root_area[order[0]];
  for (const auto i : order) {
    large = s.root_area[i];
    if ((above += s.weight[i]) >= tenth) break;
  }
  FeatureSample kept;
  for (std::size_t i = 0; i < s.features.size(); ++i) {
    if (s.root_area[i] < smallest * large) continue;
    kept.features.push_back(s.features[i]);
    kept.root_area.push_back(s.root_area[i]);
    kept.weight.push_back(s.weight[i]);
  }
  s = std::move(kept);
}

}  // namespace terrazzo::shape_estimate
