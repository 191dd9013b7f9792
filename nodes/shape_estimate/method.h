// The methods of shape estimation, as one table: a further one is a file of its own and a line in
// methods.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shape_estimate/outline.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct EstimateRequest {
  std::vector<Outline> chosen;                // of this shape, at least the method's `least` many
  const std::vector<Outline>* all = nullptr;  // every usable profile, for methods that draw on them all
  int index = 0;                              // which of several shapes, 0…
  std::uint64_t seed = 1;
  int subdivision = 1;         // levels
  int control = 0;             // control points a quarter of a curve; 0: as many as the curves need
  std::string axis = "short";  // "short" or "long"
  int base = 0;                // the profile swept along: by aspect ratio, 0 nearest to one
};

struct Estimate {
  Mesh mesh;  // mm, watertight, genus 0, outwards
  bool smooth = true;
  // How far the section at a plane of construction is from the profile (scaled) that it was made from, at
  // most; of the profile's diameter. Negative for methods that promise none.
  double deviation = -1;
};

struct EstimateMethod {
  std::string name;
  std::size_t least;  // profiles that one shape is made of
  std::size_t most;   // 0: any number
  std::string doc;
  Estimate (*run)(const EstimateRequest&, const Work&);  // null: makes all shapes at once (fit.h)
  std::size_t permutations = 0;  // bodies that the same profiles make; 0: as many as there are profiles
  bool silhouettes = false;      // profiles are kept as silhouettes, not as sections
};

const std::vector<EstimateMethod>& estimate_methods();

// Jagnow et al. 2008, section 3.1: Hobolth and Jensen's model, 30 terms. `index` and `seed` make particles
// differ.
Estimate spherical_harmonics(const EstimateRequest&, const Work&);
// Section 3.2; `deviation` is the silhouettes'. `base` 0…5 permutes the profiles.
Estimate csg(const EstimateRequest&, const Work&);
// Section 3.3, after Dischler and Ghazanfarpour 1999.
Estimate generalized_cylinder(const EstimateRequest&, const Work&);
// Section 3.4.
Estimate morphed_generalized_cylinder(const EstimateRequest&, const Work&);

// The surface swept over a frame, with as many control points as keep its curves (morph_frame.h).
struct MorphFrame;
Estimate swept_surface(const MorphFrame&, const EstimateRequest&, const Work&);

}  // namespace terrazzo::shape_estimate
