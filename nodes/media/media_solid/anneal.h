// A solid of phases whose slices show the patterns of pictures as often as these do: annealing, from coarse
// to fine. Matching the frequencies of small patterns at several distances is Deutsch's (1992) annealing with
// multiple-point statistics, here in 3D with all patterns of 3 × 3 pixels on three families of slices.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/media/micrograph/phase_map.h"
#include "runtime/work.h"

namespace terrazzo::media_solid {

struct AnnealOptions {
  Vec3i size = Vec3i::Constant(128);     // voxels; a voxel is a pixel
  std::array<int, 3> plane = {0, 0, 0};  // picture for slices across x, y, z; −1: none
  bool turned = true;                    // pictures count in all eight rotations and reflections
  std::uint64_t seed = 1;
};

struct AnnealedLevel {
  int stride = 1;  // voxels of the solid per voxel of this level
  int sweeps = 0;
  double start = 0;  // mismatch: Σ over tables and patterns of (p − q)² / (q + q₀), before and after
  double end = 0;
};

struct Solid {
  std::vector<std::uint8_t> phase;  // x fastest
  std::vector<AnnealedLevel> levels;
};

// Phases of a solid that tiles, with the pictures' fractions exact to a voxel. Pictures have equal phases. On
// planes across x, y and z the picture's columns run along y, x, x and its rows upwards along z, z, y.
Solid synthesize(const std::vector<media::PhaseMap>&, const AnnealOptions&, const Work&);

// Peak memory in bytes.
double memory_forecast(const Vec3i& size);

}  // namespace terrazzo::media_solid
