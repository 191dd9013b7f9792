// Grains that fill a periodic box: a Laguerre tessellation with given volumes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/packing/cells/effort.h"
#include "runtime/work.h"

namespace terrazzo::tessellation {

struct LaguerreOptions {
  // Thickness of the binder between two grains, mm. Nothing: what makes the grains have their volumes.
  std::optional<double> gap;
  double gap_variation = 0;  // each face's gap is within 1 ± this, times the mean; 0 to 1
  double roundness = 0;      // of edges, see round_edges; 0 to 1
  // If `gap` is nothing: the least gap, relative to the one that sharp grains would have. Edges are sharper
  // than `roundness` as far as that needs; 0: they never are.
  double least_gap = 0;
  double roughness = 0;  // root mean square displacement of faces, in mean grain diameters
  // Seeds are the centers of spheres packed to this volume fraction. The lower, the less regular are grains.
  double seed_fraction = 0.55;
  int rounds = 5;               // of moving seeds to the centroids of their cells
  Vec3 stretch = Vec3::Ones();  // proportions of an equiaxed grain along x, y, z
  double tolerance = 1e-3;      // of volumes, relative
  std::uint64_t seed = 1;
};

struct Grains {
  std::vector<Mesh> meshes;    // in the coordinates of the box; a grain at the border extends beyond it
  std::vector<double> volume;  // mm³, before roughness
  double gap = 0;              // mean, mm
  double roundness = 0;
  double worst = 0;    // largest relative error of a volume, apart from a factor common to all
  double faces = 0;    // mean number of faces of a cell
  int iterations = 0;  // Newton steps
};

// `volume`: of each grain, mm³, at most the box in total; the rest is binder. The volumes are met exactly
// also where grains are rounded or have gaps, because their cells are enlarged in turn; only if these leave
// too little, all grains are smaller by one factor. Throws Error "not-converged", and "gap-too-wide" if a
// grain is thinner than the gap.
// Once the effort is spent, volumes are only as exact as Grains::worst says.
Grains laguerre_grains(const Vec3& box, const std::vector<double>& volume, const LaguerreOptions& options,
                       Effort& effort, const Work& work = {});

}  // namespace terrazzo::tessellation
