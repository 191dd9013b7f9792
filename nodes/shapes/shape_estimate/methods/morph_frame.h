// The wire frame of the morphed generalized cylinder: a base curve and the halves of the morph curves on it.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shapes/shape_estimate/methods/arcs.h"

namespace terrazzo::shape_estimate {

// The base curve lies in z = 0. Sector j runs from the half-plane at angle j·π/(n − 1) to the next one, where
// n is the number of profiles. Half-plane j holds one half of a morph curve, which meets the base at its
// radius and all other halves at the two poles on the z axis, exactly.
struct MorphFrame {
  std::vector<Arc> base;       // per sector
  std::vector<double> radius;  // of the base at each half-plane, mm
  // Per half-plane, from its pole (t = 0) to the base (t = 1): (distance, z), mm.
  std::vector<Arc> upper, lower;
  // Distortion by region-wise scaling: the largest ratio between the scales of the regions
  // of one morph profile.
  double distortion = 1;
  // Σ log² of the scales of all regions: 0 if every morph profile keeps its size.
  double scaling = 0;
};

// Jagnow et al. 2008, sections 3.2 and 3.4. The base is the profile whose aspect ratio is closest to one, or
// the next in that order for `base` 1, …. The others stand on it, ordered by aspect ratio. With `axis`
// "short" the longest is on the longest chord, and the poles are ends of the short axes;
// with "long" the profiles stand upright and the roundest is on the longest chord. "auto" takes the one with
// less `scaling`: of the three principal sections of one body, each keeps its size and its place (errata 12).
// Profiles are mirrored to minimize scaling, and cut and scaled by regions: outwards to meet the base, and
// along the axis to meet at the poles, whose heights are the geometric means of those that the profiles
// require.
MorphFrame morph_frame(std::vector<Outline> profiles, const std::string& axis, int base = 0);

// Jagnow et al. 2008, section 3.3, as a frame whose standing curves are equal: the right half of the second
// profile by aspect ratio (lying if `axis` is "short", upright if "long", either if "auto"), cut along the
// vertical line through its centroid. It stands on the half-chord of the base that is closest to its own
// length, is scaled until it is tangent to the base there, and stretched with the base's radius. The base
// plane is where that half is widest. Of three profiles only two are used; `base` selects which. The curves
// need not be star-shaped; points behind the axis are clamped to it. Throws Error "flat-profile".
MorphFrame cylinder_frame(std::vector<Outline> profiles, const std::string& axis, int base = 0);

// The frame's closed curves in their own planes: the base in (x, y), each morph curve in (distance along its
// half-plane 0 ≤ j < n − 1, z).
std::vector<std::vector<Vec2>> frame_curves(const MorphFrame&);

// The largest distance of a point of a frame curve from the mesh's section in its plane, relative to the
// curve's diameter. 1 if the plane misses the mesh.
double frame_deviation(const MorphFrame&, const Mesh&);

}  // namespace terrazzo::shape_estimate
