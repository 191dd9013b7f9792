// Angular stones, like those from a crusher.
#pragma once

#include <cstdint>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape {

struct RockOptions {
  std::uint64_t seed = 1;
  std::uint64_t item = 0;    // index of the rock for this seed
  Vec3 axes = Vec3::Ones();  // mean proportions; each rock deviates from them by up to a quarter
  int facets = 13;           // number of large fracture faces, 4…30
  int chips = 6;             // number of corners and edges broken off, 0…20
  double roughness = 0.02;   // amplitude of the roughness of the faces, relative to the radius, 0…0.1
  int detail = 3;            // about 60·2^detail triangles, 0…6
};

// A sphere cut by `facets` planes of well-separated random directions, with corners cut by small planes,
// edges hollowed by conchoidal (spherical) chips, and a smooth random roughness. Surface points move only
// along rays from the center, so the mesh is star-shaped: watertight, genus 0 and free of
// self-intersections. Radius about 1.
Mesh rock_mesh(const RockOptions&, const Work& = {});

}  // namespace terrazzo::shape
