// Volume, ellipsoid of equal moments and contacts of single particles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/packing/measure3d/raster.h"

namespace terrazzo::measure3d {

struct Body {
  std::int32_t index = 0;  // of the particle
  std::int32_t cls = 0;    // its class; 0 if not known
  bool is_void = false;
  bool cut = false;            // touches the border of a volume that does not tile
  double volume = 0;           // mm³
  double surface = 0;          // mm²; 0 if not known
  Vec3 center = Vec3::Zero();  // of mass, mm
  // Lengths of the axes of the ellipsoid with the same inertia tensor and mass, longest first, mm.
  Vec3 axes = Vec3::Zero();
  Mat3 directions = Mat3::Identity();  // columns: unit vectors of these axes, with z ≥ 0
};

// Contact of two particles; a < b.
struct Touch {
  std::int32_t a = 0, b = 0;  // particles
  double area = 0;            // mm²
};

// From meshes, exactly. Throws Error "no-such-shape", "bad-mesh" (no volume), "bad-box".
std::vector<Body> bodies_of(const Particles&, const Shapes&, const Work&);
// From labels, ordered by index. Particles may wrap if the raster is periodic, but must be smaller than the
// box. Labels are up to 100 million; throws Error "too-many-labels" otherwise.
std::vector<Body> bodies_of(const Raster&, const Particles* particles, const Work&);

// Pairs of particles whose surfaces are nearer than `gap` mm, found exactly. The area is the mean of the two
// areas that are nearer than `gap` to the other particle, found at points of a net as fine as 1/16 of the
// particle. A pair that touches through two sides of the box is one contact with the sum of the areas.
std::vector<Touch> touches_of(const Particles&, const Shapes&, double gap, const Work&);

}  // namespace terrazzo::measure3d
