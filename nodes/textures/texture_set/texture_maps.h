// The maps of a finished plane through a packing.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/textures/relief/height_field.h"
#include "nodes/textures/texture_set/finished_surface.h"
#include "runtime/work.h"

namespace terrazzo::texture_set {

// Of surfaces, 0 to 1, as glTF and MaterialX define it.
struct Roughness {
  std::vector<double> particles;  // of each class; the last one holds beyond
  double binder = 0.4;
  // Of natural surfaces: walls of voids, sockets, and particles that the finish laid open.
  static constexpr double kNaturalParticle = 0.7, kNaturalBinder = 0.9;
};

struct TextureMaps {
  Image base_color;  // scene-linear, without light
  Image roughness;   // three equal channels, as in `occlusion` and `height` of the node
  Image id;          // id_color() of the particle at the center of each texel
  textures::HeightField height;
};

// A color for each particle, three bytes as k / 255, black for −1. Different particles have different colors:
// the bytes, red first, are the base-256 digits, lowest first, of (particle + 1) · 0x9e3779b1 modulo 2²⁴.
Vec3f id_color(std::int32_t particle);

// Texels that contain an edge are averages of 4 × 4 points. `detail` may be null; `softness`: standard
// deviation of the blur of outlines, mm.
TextureMaps paint_maps(const FinishedSurface&, const Particles&, const section::SectionLayout&,
                       const Roughness&, const residual::ResidualField* detail, double softness,
                       const Work& = {});

}  // namespace terrazzo::texture_set
