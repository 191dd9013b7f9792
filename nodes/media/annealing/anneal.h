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

namespace terrazzo::annealing {

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

// What all levels but the finest two make.
struct CoarseSolid {
  int stride = 0;  // voxels of the solid per voxel
  Vec3i size = Vec3i::Zero();
  std::vector<std::uint8_t> phase;
};

// Some layers of voxels across z.
struct Layers {
  int first = 0, count = 0;
};

// Phases of a solid that tiles, with the pictures' fractions exact to a voxel. Pictures have equal phases. On
// planes across x, y and z the picture's columns run along y, x, x and its rows upwards along z, z, y.
Solid synthesize(const std::vector<media::PhaseMap>&, const AnnealOptions&, const Work&);

// The same in two steps, for a solid of at least kLeastEdge voxels along each edge. The second makes one of
// `blocks` slabs across z, from 0, and needs no more memory than that. A slab depends on `blocks`, but not on
// which others are made, or where: slabs that meet both make the layers where they do, from the coarse solid
// alone, before their others. Each has the pictures' fractions, and all together tile. One slab is the solid
// of synthesize().
CoarseSolid synthesize_coarse(const std::vector<media::PhaseMap>&, const AnnealOptions&, const Work&);
Solid synthesize_block(const std::vector<media::PhaseMap>&, const AnnealOptions&, const CoarseSolid&,
                       int blocks, int block, const Work&);

// The layers of a slab across z of a solid with `layers`.
Layers layers_of(int blocks, int block, int layers);
constexpr double kMostVoxels = 2147483647;  // that are made at once
constexpr int kLeastEdge = 24;              // voxels
constexpr int kLeastLayers = 96;            // of a slab, if there is more than one

// Voxels of a level, of which each stands for `stride` of the solid's along each axis.
Vec3i size_at(const Vec3i& size, int stride);

// Peak memory in bytes of synthesize(), synthesize_coarse() and synthesize_block(), with the grids.
double memory_forecast(const Vec3i& size);
double coarse_forecast(const Vec3i& size);
double block_forecast(const Vec3i& size, int blocks);

}  // namespace terrazzo::annealing
