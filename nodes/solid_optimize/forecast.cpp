#include <algorithm>

#include "nodes/common/slice_axes.h"
#include "nodes/solid_optimize/blocks.h"

namespace terrazzo::solid_optimize {
namespace {

constexpr double kChannels = 3;

int planes(const SolidSettings& s) {
  return static_cast<int>(std::count_if(s.plane.begin(), s.plane.end(), [](int p) { return p >= 0; }));
}

// Of a part of a level: its voxels, and the patches of one plane, of which there is one in four voxels.
struct PartSize {
  double voxels = 1, patches = 1;
  PartSize(const LocalBox& box, const Vec3i& level) {
    for (const LocalLine& l : local_lines(box, level)) voxels *= l.to - l.from;
    patches = voxels / 4;
  }
};

// A level that is made whole, with the exemplars' features.
double whole_bytes(const SolidSettings& s, int levels, const Vec3i& size) {
  return size.cast<double>().prod() * (4 * (kChannels + (guided_levels(s, levels) > 0)) + planes(s) * 2);
}

// A part of level `level`, at the peak: what is there while the matches below are made, while they are
// carried up, while the level's own are searched (one plane's twice), and while it is finished.
double part_bytes(const SolidSettings& s, int level, int levels, const LocalBox& wanted, bool finished) {
  const int whole = whole_level(s, levels),
            rounds = iterations_of(s, levels)[static_cast<std::size_t>(level)];
  const Vec3i size = box_at(s.size, level, levels);
  const LocalBox box = local_plan(wanted, rounds, finished ? s.finish : 0).blend[0];
  const PartSize part(box, size);
  const double matches = 8 * part.patches * planes(s);
  // A plane's second copy in the search, a channel's in the finish, and one of what is wanted are there one
  // after the other, but what is freed is not always given back at once.
  const double copies =
      4 * part.patches + (finished ? 4 * part.voxels + 4 * wanted.size().cast<double>().prod() : 0);
  const double own = part.voxels * (4 * kChannels + (finished && s.sources ? 5 : 0)) + matches + copies;
  if (level - 1 == whole) return own;
  const Vec3i size_below = box_at(s.size, level - 1, levels);
  const LocalBox below = box_below(box, size, size_below);
  const PartSize kept(
      local_plan(below, iterations_of(s, levels)[static_cast<std::size_t>(level) - 1], 0).blend[0],
      size_below);
  const double carrying = kept.voxels * 4 * kChannels + 8 * kept.patches * planes(s) + matches;
  return std::max({own, carrying, part_bytes(s, level - 1, levels, below, false)});
}

}  // namespace

double memory_forecast(const std::vector<SolidExemplar>& exemplars, const SolidSettings& s) {
  const int levels = s.levels > 0 ? s.levels : natural_levels(exemplars, s.size);
  double pixels = 0;
  for (const auto& e : exemplars) pixels += static_cast<double>(e.width) * e.height;
  // Patches' features, similar ones, texels; of all levels together a third more.
  const double exemplar = pixels * (32 * 4 + ExemplarLevel::kSimilar * 4 + 16 + 40) * 4 / 3;
  const bool local = s.local && levels > 1;
  const Vec3i made = local ? block_box(s).size() : s.size;
  const double voxels = made.cast<double>().prod();
  double optimizing;
  if (local) {
    double most = 0;
    for (int l = whole_level(s, levels) + 1; l < levels; ++l)
      most = std::max(most, part_bytes(s, l, levels, probe_box(box_at(s.size, l, levels), s.local_limits),
                                       l + 1 == levels));
    most = std::max(most, part_bytes(s, levels - 1, levels, block_box(s), true));
    optimizing = exemplar + whole_bytes(s, levels, box_at(s.size, whole_level(s, levels), levels)) + most;
  } else {
    optimizing = whole_bytes(s, levels, s.size) + exemplar;
  }
  // The sum of changes and the slices' spectra: of a block there are none.
  const double finishing = s.blocks == Vec3i::Ones() ? voxels * (4 * kChannels + 4 + 4) : 0;
  const double handing_over = voxels * (4 * kChannels + 14);
  return std::max({optimizing, finishing, handing_over}) + voxels * (s.sources && !local ? 5 : 0);
}

}  // namespace terrazzo::solid_optimize
