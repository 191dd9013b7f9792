// The wire frame of the morphed generalized cylinder: one base curve and the halves of the morph curves on
// it.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shape_estimate/arcs.h"

namespace terrazzo::shape_estimate {

// The base curve lies in z = 0. Sector j runs from the half-plane at angle j·π/(n − 1) to the next one, n
// being the number of profiles; half-plane j holds one half of a morph curve, that meets the base at its
// radius and all others at the two poles on the z axis, exactly.
struct MorphFrame {
  std::vector<Arc> base;       // of each sector
  std::vector<double> radius;  // of the base at each half-plane, mm
  std::vector<Arc> upper,
      lower;  // of each half-plane, from its pole (t = 0) to the base (t = 1): (distance, z), mm
  // What region-wise scaling did to the morph profiles: the largest ratio of scales between regions of one.
  double distortion = 1;
};

// Jagnow et al. 2008, 3.2 and 3.4. The base is the profile whose aspect ratio is closest to one, or
// the next by that order for `base` 1, …. The others
// stand upright on it by aspect ratio, the longest on the longest chord ("short": the poles are ends of their
// short axes, as in the paper) or the roundest ("long"). They are mirrored so that scaling them changes
// least, and cut and scaled by regions: outwards to meet the base, along the axis to meet at the poles, whose
// heights are the geometric means of what the profiles ask for.
MorphFrame morph_frame(std::vector<Outline> profiles, const std::string& axis, int base = 0);

// Jagnow et al. 2008, 3.3, as a frame whose standing curves are one: the right half of the second profile by
// aspect ratio (upright where `axis` is "long"), cut along the vertical line through its centroid, scaled
// until it is tangent to the base at angle 0, and stretched with the base's radius. The base plane is where
// that half is widest. Of three profiles two are used, others with another `base`. Not only star-shaped
// curves; what strays behind the axis is held at it. Throws Error "flat-profile".
MorphFrame cylinder_frame(std::vector<Outline> profiles, const std::string& axis, int base = 0);

// The frame's closed curves in their own planes: the base in (x, y), each morph curve in (distance along its
// half-plane 0 ≤ j < n − 1, z).
std::vector<std::vector<Vec2>> frame_curves(const MorphFrame&);

// The largest distance of a point of a frame curve from the mesh's section in its plane, as a share of the
// curve's diameter. 1 where the plane misses the mesh.
double frame_deviation(const MorphFrame&, const Mesh&);

}  // namespace terrazzo::shape_estimate
