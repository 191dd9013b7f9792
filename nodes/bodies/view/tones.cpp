#include "nodes/bodies/view/tones.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/luminance.h"

namespace terrazzo::view {
namespace {

// Few shares, so that the curve follows the camera and not the single stone; the last ones spare highlights
// and the deepest shadows, which few pixels have.
constexpr double kShares[] = {0.01, 0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95, 0.99};
constexpr float kBlack = 1e-3F;
constexpr float kMostChange = 1.1F;  // of the logarithm: three times as light or dark

}  // namespace

void match_tones(std::span<Vec3f> colors, const std::vector<float>& tones) {
  if (tones.empty() || colors.empty()) return;
  std::vector<float> sorted;
  for (const Vec3f& c : colors) sorted.push_back(luminance_of(c));
  std::sort(sorted.begin(), sorted.end());
  std::vector<float> from, change;  // logarithms
  for (const double share : kShares) {
    const float own = std::log(kBlack + sorted[static_cast<std::size_t>(share * (sorted.size() - 1))]);
    const float wanted = std::log(kBlack + tones[static_cast<std::size_t>(share * (tones.size() - 1))]);
    const float by = std::clamp(wanted - own, -kMostChange, kMostChange);
    if (from.empty() || own > from.back()) {
      from.push_back(own);
      change.push_back(by);
    } else if (share <= 0.5) {  // of many equal ones, the middle counts
      change.back() = by;
    }
  }
  for (Vec3f& c : colors) {
    const float at = std::log(kBlack + luminance_of(c));
    const auto above = std::upper_bound(from.begin(), from.end(), at);
    float by = 0;
    if (above == from.begin()) {
      by = change.front();
    } else if (above == from.end()) {
      by = change.back();
    } else {
      const std::size_t k = above - from.begin();
      by = std::lerp(change[k - 1], change[k], (at - from[k - 1]) / (from[k] - from[k - 1]));
    }
    c *= std::exp(by);
  }
}

}  // namespace terrazzo::view
