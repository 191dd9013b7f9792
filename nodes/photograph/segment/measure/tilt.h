// Photographs of a surface that were taken at an angle: stones shrink where the surface recedes.
#pragma once

#include "nodes/data/profiles.h"

namespace terrazzo::segment {

struct TiltEstimate {
  double degrees = 0;    // between the camera's axis and the surface's normal; 0: sizes tell of none
  double direction = 0;  // degrees from 0 to below 360, where stones shrink: 0 right, 90 up
  double factor = 1;     // size of stones at the nearest edge or corner / at the farthest
};

// The tilt that the sizes of whole stones suggest, if these do not touch the border, have an outline and are
// at least 60. Let the camera be tilted by T, and a stone appear at the angle θ from the camera's axis toward
// where the surface recedes, at x = f·tan θ in the picture with the focal length f. The distance along the
// axis is proportional to cos θ / cos(T + θ), so widths across that direction are proportional to
// cos(T + θ) / cos θ = cos T · (1 − x·tan T / f), for flat stones and for balls, since nothing is
// foreshortened across. Between edges at ±E, ln width then falls by Δ = 2·atanh(E·tan T / f), and
// tan T = f/E · tanh(Δ/2). A field of view of 60° across the longer side is assumed, as of a phone's main
// camera.
//
// Δ is the slope of ln width by least squares, each stone weighted by its diameter, since small pieces are
// the least certain; along that of 18 lines at which it is most significant. The standard error is the larger
// of two: White's (1980), and that of 4 × 4 parts of the picture as clusters (Liang and Zeger 1986), since
// stones of one size lie together. A slope below 3.5 standard errors counts as none.
TiltEstimate estimated_tilt(const Profiles&);

}  // namespace terrazzo::segment
