// Features of a fixed set of sections of a body. All bodies are cut by the same planes, so that differences
// between them are not random.
#pragma once

#include <array>
#include <vector>

#include "nodes/common/stereology/outline_features.h"
#include "nodes/shapes/shape_estimate/inscribed.h"
#include "nodes/shapes/shape_estimate/outline.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct CutProfile {
  Loop loop;             // outer outline, in the body's units
  double root_area = 0;  // √area
  double perimeter = 0;
  double weight = 1;  // number of profiles that it represents
  double scale = 0;   // mm per unit of the body at which it is seen; 0: at any scale
};

// Sections with evenly spread directions and depths (R3 sequence, Roberts 2018), `planes` of them starting at
// element `first`. The weight of a direction is the body's width along it, in proportion to how often random
// planes meet it. Disjoint profiles are counted separately.
std::vector<CutProfile> cut_sections(const Mesh&, std::size_t planes, std::size_t first = 0);

// Removes sections whose root area is below `smallest` times the one that a tenth of them (by weight) exceed,
// as candidates_of does with observed profiles.
void drop_small(std::vector<CutProfile>&, double smallest);

// What is compared of an outline: its OutlineFeatures, then its inscribed_shares.
inline constexpr std::size_t kFeatures = kOutlineFeatures + kInscribed.size();
struct ProfileFeatures {
  std::array<double, kFeatures> values{};
  double operator[](OutlineFeature f) const { return values[static_cast<std::size_t>(f)]; }
};

// How the profiles of a photograph are measured, and sections of bodies like them.
struct ProfileMeasuring {
  OutlineMeasuring outline;
  // Standard deviations, mm. blur: of all smoothing of the profiles, of which a Gaussian blur of the outline
  // hides the rest. pixel: the part that the photograph itself has, without the smoothing of pixel steps.
  double blur = 0, pixel = 0;
};
// If pixel steps had to be smoothed, frayed outlines of segmentation are hidden as well, by a wider blur that
// sections of bodies get too.
ProfileMeasuring measuring_of(const std::vector<Outline>&);
ProfileFeatures profile_features(const Outline&, const ProfileMeasuring&);
// Area over that of the convex hull: of a profile, and of a section that is seen at `scale` mm per unit.
double convexity_of(const Outline&, const ProfileMeasuring&);
double convexity_of(const CutProfile&, double scale, const ProfileMeasuring&);

// Profiles of isotropic uniform random planes. Each represents `weight` profiles.
struct FeatureSample {
  std::vector<ProfileFeatures> features;
  std::vector<double> root_area;  // √area, in the units of the sections
  std::vector<double> weight;
};

double total_weight(const FeatureSample&);

// Measures sections. Outlines of sections with a scale are blurred as a photograph of that scale blurs them.
// Omits sections without area.
FeatureSample measured(const std::vector<CutProfile>&, const ProfileMeasuring&);

}  // namespace terrazzo::shape_estimate
