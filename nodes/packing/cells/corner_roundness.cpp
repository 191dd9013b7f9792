#include "nodes/packing/cells/corner_roundness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/outline_features.h"

namespace terrazzo::tessellation {
namespace {

constexpr double kRelativeBlur = 0.01;  // of outlines, relative to their length
constexpr double kPixelSteps = 1.8;     // and in steps of pixels
constexpr double kSharp = 0.02;         // a smaller roundness is none

double bend_of(const Loop& outline, double blur) {
  return outline_features(outline, {.points = 128, .blur = blur})[OutlineFeature::CurvatureHigh];
}

// A regular pentagon with edges rounded as round_edges does it.
Loop pentagon(double roundness) {
  constexpr int kPoints = 512, kSides = 5;
  const double power = 3 / roundness;
  Loop out;
  for (int i = 0; i < kPoints; ++i) {
    const double t = 2 * std::numbers::pi * i / kPoints;
    double largest = 0, sum = 0;
    for (int k = 0; k < kSides; ++k)
      largest = std::max(largest, std::cos(t - 2 * std::numbers::pi * k / kSides));
    for (int k = 0; k < kSides; ++k)
      sum += std::pow(std::max(0.0, std::cos(t - 2 * std::numbers::pi * k / kSides)) / largest, power);
    out.push_back(Vec2(std::cos(t), std::sin(t)) / (largest * std::pow(sum, 1 / power)));
  }
  return out;
}

}  // namespace

double measure_roundness(const Profiles& profiles) {
  std::vector<double> bends, blurs;
  for (const Profile& p : profiles.profiles) {
    if (p.touches_border || p.contour.size() < 24) continue;
    const double blur = std::min(
        0.05, std::hypot(kRelativeBlur, kPixelSteps * pixel_step(p.contour) / loop_perimeter(p.contour)));
    const double bend = bend_of(p.contour, blur);
    if (bend > 0) {
      bends.push_back(bend);
      blurs.push_back(blur);
    }
  }
  if (bends.size() < 3) return 0;
  const double bend = median(std::move(bends)), blur = median(std::move(blurs));
  if (bend >= bend_of(pentagon(kSharp), blur)) return 0;
  double low = kSharp, high = 1;  // the rounder, the less it bends
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (low + high);
    (bend_of(pentagon(middle), blur) > bend ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace terrazzo::tessellation
