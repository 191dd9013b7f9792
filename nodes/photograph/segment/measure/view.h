// What a photograph shows of its particles: a cut, or whole stones from outside.
#pragma once

#include <array>
#include <optional>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/photograph/marks/ignored.h"
#include "runtime/work.h"

namespace terrazzo::segment {

struct ShadingCount {
  int judged = 0, shaded = 0;  // particles
};

// A stone's middle faces the sky and its rim does not, so that it grows lighter from the rim to the middle
// all the way. In a cut, only the few pixels of the rim that the camera blurs differ from the rest.
struct ViewEvidence {
  int judged = 0;             // particles large enough to tell
  double shaded = 0;          // share of them that are shaded like stones
  Vec2 light = Vec2::Zero();  // median slope of the logarithm of luminance, per radius, right and upwards
  std::array<ShadingCount, 4> halves = {};  // of the picture: left, right, upper, lower
};

ViewEvidence view_evidence(const Image&, const Labels&, const Work&);

// Surface if the evidence says so; otherwise Filling if particles cover at least `kNoBinder` of the
// picture, or Section. With fewer than five judged particles: not Surface.
inline constexpr double kNoBinder = 0.97;
View judged_view(const ViewEvidence&, double area_fraction);

// Two halves of the picture of which one looks like a surface and the other like a cut.
struct MixedView {
  const char *surface = "", *cut = "";  // "left", "right", "upper", "lower"
  ShadingCount of_surface, of_cut;
};

// Whether halves of the picture differ, if each has at least 20 judged particles: the shares of shaded ones
// lie on both sides of the limit of judged_view(), and differ by more than 3.5 standard errors of two equal
// shares. Of both pairs of halves, the one that differs more.
std::optional<MixedView> mixed_view(const ViewEvidence&);

// Marks the profiles as seen in this view, and completes the silhouettes of a surface.
void set_view(Profiles&, View, const ViewEvidence&);

}  // namespace terrazzo::segment
