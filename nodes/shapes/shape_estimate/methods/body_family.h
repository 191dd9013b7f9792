// Families of bodies: each maps a few dozen numbers to a body.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <memory>

#include "nodes/data/shapes.h"

namespace terrazzo::shape_estimate {

// Bodies of about unit radius as a function of a parameter vector; 0 is the starting body. Meshes are closed
// and of genus 0, or without triangles if the parameters yield no body.
class BodyFamily {
 public:
  virtual ~BodyFamily() = default;
  virtual int dimensions() const = 0;
  virtual Mesh body(const Eigen::VectorXd& x) const = 0;
};

// A body deformed by fold-free maps of space, so that a body without self-intersections stays without them:
//   stretching along two of the principal axes (exponents; the third preserves the volume),
//   swelling: radii times exp of a sum of real spherical harmonics of degrees 2 to 4,
//   roughness: the same with fixed random fields of shorter wavelengths,
//   flattening: the parts beyond planes of well-separated directions, flattened to a twentieth,
// and, before those, smoothing and sharpening of the surface (a multiple of the step to its smoothed
// version), which is not a map of space and therefore bounded. Edges longer than an eighth of the radius are
// split first, for enough vertices to deform.
std::unique_ptr<BodyFamily> deformed_bodies(Mesh start, std::uint64_t seed);

// A convex polyhedron of 4 to 16 faces. Parameters: the faces' distances and tilts, stretching, swelling of
// degrees 2 and 3 and roughness as above, and wear (smoothing of edges). Unlike a deformed tessellation, it
// has sharp edges where faces meet. 0 is the body, cut by 16 planes, or one of random polyhedra, stretched by
// element `guess` of a low-discrepancy sequence, which also gives the number of faces.
std::unique_ptr<BodyFamily> faceted_bodies(Mesh start, std::uint64_t seed);
std::unique_ptr<BodyFamily> faceted_bodies(std::uint64_t seed, int guess);

// A ball deformed by modeling operations (Barr 1984): swelled by spherical harmonics of degrees 2 to 5
// and by random fields of shorter wavelengths, flattened against planes whose directions are parameters
// too, stretched, tapered, and with its long axis bent into an arc, so that the body need not be
// star-shaped. 0 is element `guess` of a low-discrepancy sequence of such bodies: bent or straight,
// flat-sided or round, elongated, flat, lumpy. `ball`: what all bodies of `seed` share, if it is made
// already.
struct SwellingBall;
std::shared_ptr<const SwellingBall> swelling_ball(std::uint64_t seed);
std::unique_ptr<BodyFamily> modeled_bodies(std::uint64_t seed, int guess,
                                           std::shared_ptr<const SwellingBall> ball = {});

// A body of lobes: 5 to 14 ellipsoids around a core, and all that lies between them and its middle.
// Star-shaped, of about unit radius. Element `guess` of a low-discrepancy sequence of numbers, depths and
// sizes of lobes.
Mesh lobed_body(std::uint64_t seed, int guess);

}  // namespace terrazzo::shape_estimate
