// Families of bodies, each a body and what a few dozen numbers make of it.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <memory>

#include "nodes/data/shapes.h"

namespace terrazzo::shape_estimate {

// Bodies of about unit radius by a vector of numbers, of which 0 is the start. Closed and of genus 0, or
// without triangles where the numbers make none.
class BodyFamily {
 public:
  virtual ~BodyFamily() = default;
  virtual int dimensions() const = 0;
  virtual Mesh body(const Eigen::VectorXd& x) const = 0;
};

// A body deformed by maps that do not fold space, so that what does not pass through itself does not begin
// to:
//   stretching along two of the principal axes (exponents; the third keeps the volume),
//   swelling: radii times exp of a sum of real spherical harmonics of the degrees 2 to 4,
//   roughness: the same with fixed random fields of shorter waves,
//   flattening: what sticks out of planes of well spread directions pressed to a twentieth,
// and, before those, smoothing and sharpening of the surface (a share of the step to its smoothed self),
// which is no map of space and kept within bounds. Edges longer than an eighth of the radius are split first,
// so that there is something to deform.
std::unique_ptr<BodyFamily> deformed_bodies(Mesh start, std::uint64_t seed);

// A convex polyhedron of planes of well spread directions, at first as far out as the body reaches: their
// distances, then wear (smoothing of edges), swelling of the degrees 2 and 3, roughness and stretching as
// above. Sharp edges are where planes meet, which a deformed tessellation cannot have.
std::unique_ptr<BodyFamily> cut_bodies(const Mesh& start, std::uint64_t seed);

// A ball made a body by the maps of a modeller (Barr 1984): swelled by spherical harmonics of the degrees 2
// to 5 and by random fields of shorter waves, pressed flat against planes whose directions move too,
// stretched, tapered, and its long axis bent into an arc: a body then that has no point whose rays leave it
// once. 0 is number `guess` of a low-discrepancy sequence of such bodies: bent or straight, flat-sided or
// round, long, flat, lumpy.
std::unique_ptr<BodyFamily> modelled_bodies(std::uint64_t seed, int guess);

}  // namespace terrazzo::shape_estimate
