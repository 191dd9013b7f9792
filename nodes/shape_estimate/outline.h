// Outlines: profiles' contours made ready for shape estimation.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// A closed simple curve about its centroid, the long principal axis of its area along x (Jagnow et al.
// 2008, 3.2).
struct Outline {
  int id = 0;                // of the profile: 1… as in Labels
  std::vector<Vec2> points;  // mm, counter-clockwise, not repeated; dense, with every corner among them
  std::vector<double>
      corner;       // at each point the turn of a corner, degrees (negative where re-entrant); 0 elsewhere
  double area = 0;  // mm²
  double perimeter = 0;          // mm
  double width = 0, height = 0;  // of the bounding box, mm
  double circularity = 0;        // 4π·area / perimeter²
  double aspect = 0;             // height / width
  double convexity = 0;          // area / area of the convex hull
  int corners = 0;               // turns of at least `crease`, either way
  double blur = 0;               // standard deviation of what smoothed pixels' steps, mm

  // Points of the curve mirrored in x, in y, or turned by a quarter; still counter-clockwise.
  Outline mirrored_x() const;
  Outline mirrored_y() const;
  Outline turned() const;
};

// What is wrong with a contour, or "": too few points, not finite, no area, meets itself (with the place).
std::string outline_fault(const std::vector<Vec2>& contour);

// Aligns, smooths and resamples a contour without fault. Jagged contours of even steps, as pixels give them,
// are smoothed by a Gaussian over 1.2 of their median point distance along the curve and scaled back to their
// area, their corners told and their tips restored by what that Gaussian does to a corner; others keep their
// points. Corners are turns of at least `crease` degrees that stay when the length over which they are
// measured is halved, so that a tight bend is none.
Outline make_outline(int id, const std::vector<Vec2>& contour, double crease);

}  // namespace terrazzo::shape_estimate
