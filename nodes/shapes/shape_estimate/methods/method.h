// The table of shape estimation methods. To add one, add a source file and an entry in methods.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shapes/shape_estimate/outline.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

enum class Tessellation {
  Fitted,  // a subdivision surface through as few points as reproduce the profiles, with creases
  Direct   // points of equation 1 of 2008 at equal arc lengths, joined by triangles
};

struct EstimateRequest {
  std::vector<Outline> chosen;                // profiles of this shape, at least the method's `least`
  const std::vector<Outline>* all = nullptr;  // every usable profile, for methods that use all of them
  int index = 0;                              // index of the shape, 0…
  std::uint64_t seed = 1;
  int subdivision = 1;  // levels
  int control = 0;      // control points per quarter of a curve; 0: as many as the curves need
  Tessellation tessellation = Tessellation::Fitted;  // of the cylinders
  std::string axis = "auto";                         // "auto", "short" or "long"
  int base = 0;       // index of the base profile: 0 has the aspect ratio closest to one
  double relief = 0;  // usual relief of all profiles (relief.h)
};

struct Estimate {
  Mesh mesh;  // mm, watertight, genus 0, facing outwards
  bool smooth = true;
  // Largest distance between the section at a plane of construction and the (scaled) profile used there,
  // relative to the profile's diameter. Negative for methods that do not reproduce profiles.
  double deviation = -1;
};

struct EstimateMethod {
  std::string name;
  std::size_t least;  // smallest number of profiles per shape
  std::size_t most;   // largest number of profiles per shape; 0: any
  std::string doc;
  Estimate (*run)(const EstimateRequest&, const Work&);  // null: all shapes are estimated together (fit.h)
  std::size_t permutations = 0;  // number of bodies from the same profiles; 0: the number of profiles
  bool silhouettes = false;      // profiles are reproduced as silhouettes, not as sections
  bool lies =
      false;  // the first profile lies in the x-y plane, with the upper side above and the lower below it
};

const std::vector<EstimateMethod>& estimate_methods();

// Jagnow et al. 2008, section 3.1: Hobolth and Jensen's model with 30 terms. `index` and `seed`
// select the random particle.
Estimate spherical_harmonics(const EstimateRequest&, const Work&);
// Section 3.2; `deviation` is that of the silhouettes. `base` 0…5 permutes the profiles.
Estimate csg(const EstimateRequest&, const Work&);
// Section 3.3, after Dischler and Ghazanfarpour 1999.
Estimate generalized_cylinder(const EstimateRequest&, const Work&);
// Section 3.4.
Estimate morphed_generalized_cylinder(const EstimateRequest&, const Work&);

// The body whose silhouette from above is the profile. Its height is the root of the solution of ∇²u = −1
// that is 0 on the outline, as in Joshi and Carr 2008 ("Repoussé"): an ellipse becomes an ellipsoid. Worn
// faces give it the relief in height that outlines have in the plane; below kRound it becomes an ellipsoid.
// Bays that no ray from the center reaches are filled.
Estimate inflation(const EstimateRequest&, const Work&);

// A convex polyhedron with worn edges, as of crushed rock. Its silhouette from above is about a polygon with
// few corners that has the form of the profile's hull, and its area; one or two faces stand at each side.
Estimate faceted(const EstimateRequest&, const Work&);

// The surface swept over a frame (morph_frame.h): fitted with enough control points to reproduce its curves,
// or direct with about 8·2^subdivision points per quarter of each curve.
struct MorphFrame;
Estimate swept_surface(const MorphFrame&, const EstimateRequest&, const Work&);

}  // namespace terrazzo::shape_estimate
