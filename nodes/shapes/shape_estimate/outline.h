// Outlines: contours of profiles, prepared for shape estimation.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Pixel steps are smoothed by a Gaussian of this standard deviation, in median point distances.
inline constexpr double kSmoothing = 1.2;

// A closed simple curve about its centroid, with the long principal axis of its area along x (Jagnow et
// al. 2008, section 3.2).
struct Outline {
  int id = 0;                // of the profile: 1…, as in Labels
  std::vector<Vec2> points;  // mm, counter-clockwise, not repeated; dense, including every corner
  // Turn at each point that is a corner, degrees (negative if re-entrant); 0 elsewhere.
  std::vector<double> corner;
  double area = 0;               // mm²
  double perimeter = 0;          // mm
  double width = 0, height = 0;  // of the bounding box, mm
  double circularity = 0;        // 4π·area / perimeter²
  double aspect = 0;             // height / width
  double convexity = 0;          // area / area of the convex hull
  int corners = 0;               // number of turns of at least `crease`, in either direction
  std::vector<Vec2> traced;      // as given, with its pixel steps; empty if not smoothed
  std::vector<Vec2> soft;  // after smoothing, before tips of corners were restored; empty if not smoothed
  // In the photograph: the place of the centroid, mm, and the angle of the curve's x axis, radians. Not kept
  // by mirroring and turning.
  Vec2 center = Vec2::Zero();
  double turn = 0;
  double blur = 0;  // standard deviation of the smoothing of pixel steps, mm; 0: not smoothed

  // The curve mirrored in x, mirrored in y, or rotated by a quarter turn; still counter-clockwise.
  Outline mirrored_x() const;
  Outline mirrored_y() const;
  Outline turned() const;
};

// Describes the fault of a contour: too few points, not finite, no area, or a self-crossing with its
// position. "" if there is none.
std::string outline_fault(const std::vector<Vec2>& contour);

// Aligns, smooths and resamples a contour without fault. Jagged contours with even steps, as from pixels, are
// smoothed along the curve by a Gaussian of 1.2 times their median point distance and scaled back to their
// area. Turns are corrected and tips restored for the effect of that Gaussian on corners. Other contours keep
// their points. Corners are turns of at least `crease` degrees that persist when the length over which they
// are measured is halved, so that a tight bend is not a corner.
Outline make_outline(int id, const std::vector<Vec2>& contour, double crease);

}  // namespace terrazzo::shape_estimate
