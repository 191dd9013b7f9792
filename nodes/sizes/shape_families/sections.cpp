#include "nodes/sizes/shape_families/sections.h"

#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
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
  double mean = 0, probability = 0, hits = 0;
  for (const Shape& s : shapes.shapes) {
    mean += s.probability * s.size();
    probability += s.probability;
    hits += s.probability * s.mean_caliper / s.size();
  }
  mean /= probability;
  FamilySections out;
  std::vector<BodySection> sections;
  std::vector<double> natural;
  // At size 1, random planes hit shapes by their numbers and mean caliper diameters. Each shape has its share
  // of the sections, rounded so that all shares add up.
  double before = 0;
  for (const Shape& s : shapes.shapes) {
    const double after = before + s.probability * s.mean_caliper / s.size() / hits * count;
    const std::size_t first = std::llround(before), last = std::llround(after);
    before = after;
    if (last == first) continue;
    Shapes one;
    one.shapes = {s};
    one.shapes[0].probability = 1;
    for (auto& section : random_sections(one, last - first, {.seed = seed, .first = first}, work.quiet())) {
      for (auto& profile : section)
        for (Loop& loop : profile)
          for (Vec2& v : loop) v /= s.size();
      sections.push_back(std::move(section));
      natural.push_back(s.size() / mean);
    }
  }
  std::vector<const Loop*> outlines;
  for (std::size_t i = 0; i < sections.size(); ++i)
    for (const auto& profile : sections[i]) {
      double area = 0;
      for (const Loop& loop : profile) area += loop_area(loop);  // holes are negative
      if (!(area > 0)) continue;
      out.ratio.push_back(std::sqrt(4 * area / pi));
      out.natural.push_back(natural[i]);
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
