// Angular stones as a crusher makes them.
#pragma once

#include <cstdint>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo {

struct RockOptions {
  std::uint64_t seed = 1;
  std::uint64_t item = 0;    // which rock of the seed
  Vec3 axes = Vec3::Ones();  // mean proportions; each rock's own depart from them by up to a quarter
  int facets = 13;           // large fracture faces, 4…30
  int chips = 6;             // corners and edges broken off, 0…20
  double roughness = 0.02;   // amplitude of the unevenness of the faces, of the radius, 0…0.1
  int detail = 3;            // triangles: about 60·2^detail, 0…6
};

// A sphere cut by `facets` planes of well separated random directions, corners cut by small planes and edges
// hollowed by conchoidal (spherical) chips, then uneven by a smooth random field. Every surface point moves
// along the ray from the centre alone, so the mesh is star-shaped: watertight, genus 0 and free of
// self-intersections. About unit radius.
Mesh rock_mesh(const RockOptions&, const Work& = {});

}  // namespace terrazzo
