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

// Sizes that decide how a local solid is made, and so its result. Tests make them small.
struct LocalLimits {
  double whole = 128.0 * 128 * 128;  // most voxels of the finest level that is made whole; the coarsest
                                     // always is. It takes as long as a block, since each run makes it again
  int probe = 80;    // edge in voxels of the cube where a level's statistics are measured; with 48, patch
                     // distances were a third larger
  int closed = 128;  // axes of at most so many voxels are measured and made in full, since a part would need
                     // as much around it
};

struct SolidSettings {
  Vec3i size = Vec3i::Constant(64);
  std::array<int, 3> plane = {0, 0, 0};       // exemplar index for slices across x, y, z; −1: none
  std::vector<int> iterations = {20, 10, 5};  // per level, coarsest first; the last one repeats
  int levels = 0;                             // 0: until the smallest exemplar has 24 to 47 pixels per side
  bool lab = true;
  double exponent = 0.8;  // r of ‖·‖^r
  double overuse = 1;
  double copying = 1;    // penalty on copying the neighbors' exemplar layout (search.h)
  double guide = 1;      // weight of the guidance channel (guide.h), on levels that are made whole
  double window = 0.05;  // of the mean shift at the end of each level; it starts ten times as wide
  int finish = 2;        // rounds of matching the finest bands
  bool sources = false;  // record where each voxel comes from
  bool papers = false;   // use the reference method: Laursen, Ersbøll and Bærentzen 2011
  bool local = false;    // blockwise: make the finer levels with passes that see only a bounded neighborhood
  int local_iterations = 2;      // per blockwise level; 0: as in `iterations`
  Vec3i blocks = Vec3i::Ones();  // number of blocks of a local solid along each axis
  LocalLimits local_limits;
  int block = 0;  // block to make: (z·blocks.y + y)·blocks.x + x
  std::uint64_t seed = 1;
};

// Measures over all slices across one axis; names with "worst" are of a single slice.
struct PlaneMeasures {
  int axis = 0;
  double histogram = 0;  // mean over quantiles of |Q_s − Q_e|, averaged over the channels
  double patches = 0;    // sliced Wasserstein distance of 7 × 7 patches, root mean square of three scales
  double patches_floor = 0;   // the same between two halves of the exemplar
  double seam = 1;            // gradient across the wrap along this axis / inside
  double copied = 0;          // fraction of neighboring matches that are also neighbors in the exemplar
  double copied_worst = 0;    // of the slice where it is largest
  double stripes_worst = 1;   // factor by which squared gradients along columns and rows are more
                              // one-directional than the exemplar's, for the most striped slice
  std::vector<double> bands;  // per scale (high-pass, scales, low-pass): σ of the slices' bands / the
                              // exemplar's, root mean square over orientations and channels
};

struct SolidResult {
  Vec3i size = Vec3i::Zero();    // of the field: the whole solid or the block
  Vec3i origin = Vec3i::Zero();  // of the field in the solid
  ColorAxes axes;
  SolidField field;      // in the working axes
  BlendSources sources;  // of the last blend, before the finish
  int levels = 0;
  std::vector<PlaneMeasures> measures;  // one per constrained axis
};

// Exemplars must have the scale of the solid: a pixel is a voxel. The whole solid tiles. Throws Error
// "exemplar-too-small", "one-color", and "bad-value" if a local solid has only one level. `gl`, if set, makes
// a local solid's finer levels; it must have been made on this thread.
SolidResult optimize_solid(const std::vector<SolidExemplar>&, const SolidSettings&, const Work&,
                           LocalGl* gl = nullptr);

// A local solid in two steps: the data that all blocks share (blocks.h), then the block that the settings
// name. Exemplars and settings must be the same except for the block. The blocks are those of the solid that
// optimize_solid makes.
LocalBase solid_base(const std::vector<SolidExemplar>&, const SolidSettings&, const Work&);
SolidResult solid_block(const std::vector<SolidExemplar>&, const SolidSettings&, const LocalBase&,
                        const Work&, LocalGl* gl = nullptr);

// The number of levels that optimize_solid uses for `levels` = 0.
int natural_levels(const std::vector<SolidExemplar>&, const Vec3i& size);
// Peak memory in bytes, within about a tenth: for a whole solid, and for the two steps of a local one.
double memory_forecast(const std::vector<SolidExemplar>&, const SolidSettings&);
double base_forecast(const std::vector<SolidExemplar>&, const SolidSettings&);
double block_forecast(const std::vector<SolidExemplar>&, const SolidSettings&);

}  // namespace terrazzo::solid_optimize
