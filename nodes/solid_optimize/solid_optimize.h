// Solid textures from pictures of their sections: texture optimization, coarse to fine.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "nodes/solid_optimize/blend.h"
#include "nodes/solid_optimize/colors.h"

namespace terrazzo::solid_optimize {

constexpr const char* kAxes[3] = {"x", "y", "z"};  // as parameters and tables name them

class LocalGl;
struct LocalBase;

// Sizes that decide how a local solid is made, and what it becomes; tests make them small.
struct LocalLimits {
  double whole = 128.0 * 128 * 128;  // voxels of the finest level that is made whole, unless the coarsest has
                                     // more: as long as a block, since each run makes it anew
  int probe = 80;    // voxels along each axis on which a level's statistics are measured: with 48 patch
                     // distances were a third larger
  int closed = 128;  // along axes of at most so many all are, since a part needs as much around itself
};

struct SolidSettings {
  Vec3i size = Vec3i::Constant(64);
  std::array<int, 3> plane = {0, 0, 0};       // the exemplar seen on slices across x, y, z; −1: none
  std::vector<int> iterations = {20, 10, 5};  // from the coarsest level on; the last one for levels beyond
  int levels = 0;                             // 0: until the smallest exemplar has 24 to 47 pixels a side
  bool lab = true;
  double exponent = 0.8;  // r of ‖·‖^r
  double overuse = 1;
  double copying = 1;    // how much a patch counts as further that goes on from its neighbours' (search.h)
  double guide = 1;      // weight of the distance to borders (guide.h), on levels that are made whole
  double window = 0.05;  // of the mean shift at the end of each level; it starts ten times as wide
  int finish = 2;        // rounds of matching the finest bands
  bool sources = false;  // say where each voxel comes from
  bool papers = false;   // the recipe of Laursen, Ersbøll and Bærentzen 2011 instead
  bool local = false;    // the finer levels by passes that know of a voxel's surroundings alone
  int local_iterations = 2;      // of those; 0: as `iterations` says
  Vec3i blocks = Vec3i::Ones();  // into which a local solid is cut along each axis
  LocalLimits local_limits;
  int block = 0;  // the one to make: (z·blocks.y + y)·blocks.x + x
  std::uint64_t seed = 1;
};

// Of all slices across one axis, unless the name says worst.
struct PlaneMeasures {
  int axis = 0;
  double histogram = 0;  // mean over quantiles of |Q_s − Q_e|, mean of the channels
  double patches = 0;    // sliced Wasserstein distance of 7 × 7 patches, root mean square of three scales
  double patches_floor = 0;   // the same between two halves of the exemplar
  double seam = 1;            // gradient across the wrap along this axis / inside
  double copied = 0;          // share of neighbouring matches that go on in the exemplar as they lie
  double copied_worst = 0;    // of the slice where it is largest
  double stripes_worst = 1;   // how many times more one-directional squared gradients along columns and rows
                              // are than the exemplar's, of the slice where they are most so
  std::vector<double> bands;  // per scale (high-pass, scales, low-pass): σ of the slices' bands / the
                              // exemplar's, root mean square over orientations and channels
};

struct SolidResult {
  Vec3i size = Vec3i::Zero();    // of the field: the solid's, or the block's
  Vec3i origin = Vec3i::Zero();  // of the field in the solid
  ColorAxes axes;
  SolidField field;      // in the working axes
  BlendSources sources;  // of the last blending, before the finish
  int levels = 0;
  std::vector<PlaneMeasures> measures;  // of each constrained axis
};

// Exemplars at the scale of the solid: a pixel is a voxel. The whole solid tiles. Throws Error
// "exemplar-too-small", "one-color", "bad-value" where a local solid has one level only.
// A local solid's finer levels are made by `gl` where there is one, which lives on this thread.
SolidResult optimize_solid(const std::vector<SolidExemplar>&, const SolidSettings&, const Work&,
                           LocalGl* gl = nullptr);

// A local solid in two steps: what all its blocks share (blocks.h), and the block that the settings name; the
// same exemplars and settings but for that. Blocks are those of the solid that optimize_solid makes.
LocalBase solid_base(const std::vector<SolidExemplar>&, const SolidSettings&, const Work&);
SolidResult solid_block(const std::vector<SolidExemplar>&, const SolidSettings&, const LocalBase&,
                        const Work&, LocalGl* gl = nullptr);

// Levels that optimize_solid takes for `levels` = 0.
int natural_levels(const std::vector<SolidExemplar>&, const Vec3i& size);
// Bytes at the peak, within a tenth or so: of a whole solid, and of the two steps of a local one.
double memory_forecast(const std::vector<SolidExemplar>&, const SolidSettings&);
double base_forecast(const std::vector<SolidExemplar>&, const SolidSettings&);
double block_forecast(const std::vector<SolidExemplar>&, const SolidSettings&);

}  // namespace terrazzo::solid_optimize
