#include "nodes/shape_families/sections.h"

#include <cmath>
#include <numbers>

#include "nodes/common/geometry/loop.h"
#include "nodes/common/stereology/outline_features.h"
#include "nodes/common/stereology/random_sections.h"

namespace terrazzo::shape_families {
namespace {

using std::numbers::pi;

constexpr double kBlurSteps = 1.8;  // least blur, in steps of an outline that follows pixels
// Outlines with fewer points are polygons cut from facets, not traced from pixels: a traced outline has about
// as many points as its length in pixels.
constexpr std::size_t kTraced = 12;

Features features_of(const Loop& outline, double blur) {
  const OutlineFeatures f = outline_features(outline, {.points = 128, .blur = blur});
  return {4 * pi * f[OutlineFeature::Circularity], f[OutlineFeature::Aspect], f[OutlineFeature::Corner]};
}

}  // namespace

std::optional<MeasuredProfile> measured(const Profile& p) {
  if (p.touches_border || p.contour.size() < 3) return {};
  const double step = p.contour.size() < kTraced ? 0 : pixel_step(p.contour);
  const double need = kBlurSteps * step / loop_perimeter(p.contour);
  MeasuredProfile out;
  while (out.level < kBlur.size() && kBlur[out.level] < need) ++out.level;
  if (out.level == kBlur.size()) return {};
  out.features = features_of(p.contour, kBlur[out.level]);
  for (const double v : out.features)
    if (!std::isfinite(v)) return {};
  return out;
}

FamilySections family_sections(const Shapes& shapes, std::size_t count, std::uint64_t seed,
                               const Work& work) {
  Shapes unit = shapes;
  for (Shape& s : unit.shapes) {
    const double scale = 1 / s.size();
    for (Vec3& v : s.mesh.vertices) v *= scale;
    s.mean_caliper *= scale;
  }
  const auto sections = random_sections(unit, count, {.seed = seed}, work.part(0, 0.3));
  FamilySections out;
  std::vector<const Loop*> outlines;
  for (const BodySection& section : sections)
    for (const auto& profile : section) {
      double area = 0;
      for (const Loop& loop : profile) area += loop_area(loop);  // holes are negative
      if (!(area > 0)) continue;
      out.ratio.push_back(std::sqrt(4 * area / pi));
      outlines.push_back(&profile.front());
    }
  for (auto& f : out.features) f.resize(outlines.size());
  work.part(0.3, 1).parallel(outlines.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      work.check();
      for (std::size_t l = 0; l < kBlur.size(); ++l) out.features[l][i] = features_of(*outlines[i], kBlur[l]);
    }
  });
  return out;
}

}  // namespace terrazzo::shape_families
