// How a solid looks in maps, and what the nodes that make maps read of it.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/linear.h"
#include "runtime/context.h"

namespace terrazzo::textures {

// Of surfaces, 0 to 1, as glTF and MaterialX define it.
struct Roughness {
  std::vector<double> particles;  // of each class; the last one holds beyond
  double binder = 0.4;
  // Of natural surfaces: walls of voids, sockets, and particles that the finish laid open.
  static constexpr double kNaturalParticle = 0.7, kNaturalBinder = 0.9;
  // Of polished ones.
  static constexpr double kPolishedParticle = 0.15, kPolishedBinder = 0.4;

  double of_class(std::int32_t cls) const;
};

// A color for each particle, three bytes as k / 255, black for −1. Different particles have different colors:
// the bytes, red first, are the base-256 digits, lowest first, of (particle + 1) · 0x9e3779b1 modulo 2²⁴.
Vec3f id_color(std::int32_t particle);

// Without what the photograph's light adds, which is not part of the material.
Detail unlit(Detail);

// Refuses a blur of outlines that would take most of the memory and time, as texels much smaller than the
// photograph's pixels do, for example on a mesh in another unit. `texel`: mm. Throws Error "bad-value", which
// names the parameter and says the hint.
void check_softness(const Detail&, double texel, const char* parameter, const char* hint);

// Of the inputs particles, shapes and volume. Throws Error "two-sources", "missing-input".
void require_one_solid(const Context&);

}  // namespace terrazzo::textures
