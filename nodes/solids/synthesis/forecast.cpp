#include <algorithm>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/solids/synthesis/blockwise/blocks.h"
#include "nodes/solids/synthesis/optimize_solid.h"

namespace terrazzo::solids {
namespace {

constexpr double kChannels = 3;

int planes(const SolidOptions& s) {
  return std::count_if(s.plane.begin(), s.plane.end(), [](int p) { return p >= 0; });
}

// The voxels of a part of a level, and the patches of one plane: one for every four voxels.
struct PartSize {
  double voxels = 1, patches = 1;
  PartSize(const TorusBox& box, const Vec3i& level) {
    for (const TorusLine& l : torus_lines(box, level)) voxels *= l.to - l.from;
    patches = voxels / 4;
  }
};

// Bytes of a level that is made whole, with the exemplars' features.
double whole_bytes(const SolidOptions& s, int levels, const Vec3i& size) {
  return size.cast<double>().prod() * (4 * (kChannels + (guided_levels(s, levels) > 0)) + planes(s) * 2);
}

// Peak bytes of a part of level `level`: what is held while the matches below are made, while they are
// carried up, while the level's own are searched (one plane's twice), and while it is finished.
double part_bytes(const SolidOptions& s, int level, int levels, const TorusBox& wanted, bool finished) {
  const int whole = whole_level(s, levels), rounds = iterations_of(s, levels)[level];
  const Vec3i size = box_at(s.size, level, levels);
  const TorusBox box = block_plan(wanted, rounds, finished ? s.finish : 0).blend[0];
  const PartSize part(box, size);
  const double matches = 8 * part.patches * planes(s);
  // A plane's second copy in the search, a channel's in the finish and one of the wanted voxels are never
  // held together, but freed memory does not always return to the system at once.
  const double copies =
      4 * part.patches + (finished ? 4 * part.voxels + 4 * wanted.size().cast<double>().prod() : 0);
  const double own = part.voxels * (4 * kChannels + (finished && s.sources ? 5 : 0)) + matches + copies;
  if (level - 1 == whole) return own;
  const Vec3i size_below = box_at(s.size, level - 1, levels);
  const TorusBox below = box_below(box, size, size_below);
  const PartSize kept(block_plan(below, iterations_of(s, levels)[level - 1], 0).blend[0], size_below);
  const double carrying = kept.voxels * 4 * kChannels + 8 * kept.patches * planes(s) + matches;
  return std::max({own, carrying, part_bytes(s, level - 1, levels, below, false)});
}

int levels_of(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s) {
  return s.levels > 0 ? s.levels : natural_levels(exemplars, s.size);
}

// Patches' features, similar patches and texels. All coarser levels together add a third.
double exemplar_bytes(const std::vector<SolidExemplar>& exemplars) {
  double pixels = 0;
  for (const auto& e : exemplars) pixels += static_cast<double>(e.width) * e.height;
  return pixels * (32 * 4 + ExemplarLevel::kSimilar * 4 + 16 + 40) * 4 / 3;
}

}  // namespace

double base_forecast(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s) {
  const int levels = levels_of(exemplars, s), whole = whole_level(s, levels);
  double most = 0;
  for (int l = whole + 1; l < levels; ++l)
    most = std::max(most, part_bytes(s, l, levels, probe_box(box_at(s.size, l, levels), s.blockwise_limits),
                                     l + 1 == levels));
  return exemplar_bytes(exemplars) + whole_bytes(s, levels, box_at(s.size, whole, levels)) + most;
}

double block_forecast(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s) {
  const int levels = levels_of(exemplars, s);
  const double whole = box_at(s.size, whole_level(s, levels), levels).cast<double>().prod() * planes(s) * 2,
               voxels = block_box(s).size().cast<double>().prod();
  return std::max(exemplar_bytes(exemplars) + whole + part_bytes(s, levels - 1, levels, block_box(s), true),
                  voxels * (4 * kChannels + 14));
}

double memory_forecast(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s) {
  const double voxels = s.size.cast<double>().prod();
  if (s.method == SolidMethod::Blockwise && levels_of(exemplars, s) > 1)
    return std::max(base_forecast(exemplars, s), block_forecast(exemplars, s));
  const double optimizing = whole_bytes(s, levels_of(exemplars, s), s.size) + exemplar_bytes(exemplars);
  const double finishing = voxels * (4 * kChannels + 4 + 4);  // the sum of changes and the slices' spectra
  const double handing_over = voxels * (4 * kChannels + 14);
  return std::max({optimizing, finishing, handing_over}) + voxels * (s.sources ? 5 : 0);
}

}  // namespace terrazzo::solids
