#include "nodes/shapes/shape_estimate/section_sample.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/random_sections.h"

namespace terrazzo::shape_estimate {
namespace {

constexpr int kOutlinePoints = 128;  // as in ShapeMetrics
constexpr double kMostBlur = 0.05;   // as OutlineMeasuring allows
// Blur of outlines, relative to their length: hides the triangles of a body and of an original, and what
// segmentation does to an outline. In addition, a multiple of the smoothing that pixel steps need.
constexpr double kMeshBlur = 0.0045, kFrayBlur = 0.009, kPixelBlur = 1.5;
// The part of it that pixels and segmentation cause, in pixel steps.
constexpr double kPixel = 0.55;

// Blur that an outline lacks, relative to its length.
double further_blur(const Outline& o, const ProfileMeasuring& how) {
  return std::sqrt(std::max(0.0, how.blur * how.blur - o.blur * o.blur)) / o.perimeter;
}

double convexity_of(const Loop& loop, OutlineMeasuring how, double more) {
  how.blur = std::min(kMostBlur, std::hypot(how.blur, more));
  const Loop points = measured_points(loop, how);
  const double hull = hull_area(points);
  return hull > 0 ? std::min(1.0, loop_area(points) / hull) : 1;
}

// Features of an outline that is blurred by `more`, and inscribed shares of one that is as sharp as the
// photograph, blurred by `pixel`; both relative to its length.
ProfileFeatures features_of(const Loop& soft, OutlineMeasuring how, double more, const Loop& sharp,
                            double pixel) {
  how.blur = std::min(kMostBlur, std::hypot(how.blur, more));
  const OutlineFeatures outline = outline_features(soft, how);
  // Areas need fewer points than curvatures.
  const auto shares = inscribed_shares(
      measured_points(sharp, {.points = how.points / 2, .blur = std::min(kMostBlur, pixel)}));
  ProfileFeatures f;
  std::copy(outline.values.begin(), outline.values.end(), f.values.begin());
  std::copy(shares.begin(), shares.end(), f.values.begin() + kOutlineFeatures);
  return f;
}

}  // namespace

std::vector<CutProfile> cut_sections(const Mesh& mesh, std::size_t planes, std::size_t first) {
  std::vector<CutProfile> out;
  MeshCutter cutter(mesh);
  for (std::size_t i = 0; i < planes; ++i) {
    const double k = first + i + 1;
    const auto part = [&](double step) { return std::fmod(0.5 + step * k, 1.0); };
    const double z = part(0.8191725133961645), phi = 2 * std::numbers::pi * part(0.6710436067037893),
                 depth = part(0.5497004779019703), r = std::sqrt(1 - z * z);
    const Vec3 u(r * std::cos(phi), r * std::sin(phi), z);
    const auto [low, high] = cutter.turn(u);
    for (auto& profile : section_profiles(cutter.loops(frame_about(u), low + depth * (high - low)))) {
      CutProfile s;
      s.loop = std::move(profile[0]);
      const double area = loop_area(s.loop);
      if (!(area > 0)) continue;
      s.root_area = std::sqrt(area);
      s.perimeter = loop_perimeter(s.loop);
      s.weight = high - low;
      out.push_back(std::move(s));
    }
  }
  return out;
}

void drop_small(std::vector<CutProfile>& sections, double smallest) {
  if (smallest <= 0 || sections.empty()) return;
  std::vector<std::size_t> order(sections.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) {
    return sections[a].root_area > sections[b].root_area ||
           (sections[a].root_area == sections[b].root_area && a < b);
  });
  double total = 0, above = 0;
  for (const CutProfile& s : sections) total += s.weight;
  double large = sections[order[0]].root_area;
  for (const auto i : order) {
    large = sections[i].root_area;
    if ((above += sections[i].weight) >= total / 10) break;
  }
  std::erase_if(sections, [&](const CutProfile& s) { return s.root_area < smallest * large; });
}

ProfileMeasuring measuring_of(const std::vector<Outline>& all) {
  std::vector<double> blurs;
  for (const Outline& o : all) blurs.push_back(o.blur);
  const double blur = kPixelBlur * median(std::move(blurs));
  ProfileMeasuring out;
  out.outline.points = kOutlinePoints;
  out.outline.blur = blur > 0 ? kFrayBlur : kMeshBlur;
  out.blur = blur;
  out.pixel = kPixel / (kPixelBlur * kSmoothing) * blur;
  return out;
}

double convexity_of(const Outline& o, const ProfileMeasuring& how) {
  return convexity_of(o.soft.empty() ? o.points : o.soft, how.outline, further_blur(o, how));
}

double convexity_of(const CutProfile& s, double scale, const ProfileMeasuring& how) {
  const double length = s.perimeter * scale;
  return convexity_of(s.loop, how.outline, length > 0 ? how.blur / length : 0);
}

ProfileFeatures profile_features(const Outline& o, const ProfileMeasuring& how) {
  return features_of(o.soft.empty() ? o.points : o.soft, how.outline, further_blur(o, how),
                     o.traced.empty() ? o.points : o.traced, 0);
}

double total_weight(const FeatureSample& s) { return std::accumulate(s.weight.begin(), s.weight.end(), 0.0); }

FeatureSample measured(const std::vector<CutProfile>& sections, const ProfileMeasuring& how) {
  FeatureSample out;
  for (const CutProfile& s : sections) {
    const double length = s.perimeter * s.scale;  // mm
    const ProfileFeatures f = features_of(s.loop, how.outline, length > 0 ? how.blur / length : 0, s.loop,
                                          length > 0 ? how.pixel / length : 0);
    if (f[OutlineFeature::Circularity] <= 0) continue;
    out.features.push_back(f);
    out.root_area.push_back(s.root_area);
    out.weight.push_back(s.weight);
  }
  return out;
}

}  // namespace terrazzo::shape_estimate
