#include "nodes/solids/synthesis/blockwise/finish.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/whole/finish.h"
#include "nodes/solids/synthesis/whole/levels.h"

namespace terrazzo::solids {
namespace {

struct Strides {
  std::array<std::size_t, 3> step;
  Vec3i from;
  explicit Strides(const BlockRegion& r)
      : step{1, static_cast<std::size_t>(r.field.size.x()), pixels_in(r.field.size.x(), r.field.size.y())},
        from(r.lines[0].from, r.lines[1].from, r.lines[2].from) {}
  std::size_t of(const Vec3i& at) const {
    std::size_t i = 0;
    for (int a = 0; a < 3; ++a) i += (at[a] - from[a]) * step[a];
    return i;
  }
};

// Splits one slice of a box into bands.
void split_slice(const BlockRegion& region, int channel, int axis, int slice, const TorusBox& box,
                 FinestBands& bands) {
  const Strides strides(region);
  const int u = kSliceColumns[axis], v = kSliceRows[axis];
  const int w = box.hi[u] - box.lo[u] + 2 * kFinishReach, h = box.hi[v] - box.lo[v] + 2 * kFinishReach;
  bands.picture.resize(pixels_in(w, h));
  Vec3i at;
  at[axis] = slice;
  at[u] = box.lo[u] - kFinishReach;
  at[v] = box.lo[v] - kFinishReach;
  const float* first = &region.field.channel[channel][strides.of(at)];
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      bands.picture[pixel_at(x, y, w)] = first[y * strides.step[v] + x * strides.step[u]];
  bands.split(w, h);
}

// The maps of the bands of all slices across an axis, from what a box has to what is wanted.
std::vector<ValueMap> band_maps(const std::vector<Quantiles>& wanted, int channel, int axis,
                                const TorusBox& measured, const BlockRegion& region, const Work& work) {
  const Vec3i extent = measured.size();
  const std::size_t slices = extent[axis];
  const std::size_t each = voxels(extent) / slices;
  std::array<std::vector<float>, kFinishBands> seen;
  for (auto& values : seen) values.resize(each * slices);
  work.parallel(slices, 4, [&](std::size_t begin, std::size_t end) {
    FinestBands bands;
    for (std::size_t s = begin; s < end; ++s) {
      split_slice(region, channel, axis, measured.lo[axis] + static_cast<int>(s), measured, bands);
      for (std::size_t b = 0; b < kFinishBands; ++b)
        std::copy(bands.band[b].begin(), bands.band[b].end(), seen[b].begin() + (s * each));
    }
  });
  std::array<std::optional<ValueMap>, kFinishBands> fixed;
  work.parallel(kFinishBands, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) fixed[b].emplace(seen[b], wanted[b]);
  });
  std::vector<ValueMap> out;
  for (const auto& m : fixed) out.push_back(*m);
  return out;
}

// One round on one channel, in `box`.
void finish_round(const BlockFinish& finish, int channel, const TorusBox& box, FinishMaps& maps,
                  BlockRegion& region, const Work& work) {
  const std::size_t c = channel;
  const TorusBox* const measured = finish.measured;
  if (measured)
    for (const NeighborField& f : region.families)
      maps.bands.push_back(band_maps(finish.bands[f.exemplar][c], channel, f.axis, *measured, region, work));
  const float share = finish_share(region.families.size());
  const Strides strides(region);
  std::vector<float> sum = region.field.channel[c];
  for (std::size_t k = 0; k < region.families.size(); ++k) {
    const int axis = region.families[k].axis;
    const int u = kSliceColumns[axis], v = kSliceRows[axis];
    work.parallel(box.hi[axis] - box.lo[axis], 4, [&](std::size_t begin, std::size_t end) {
      FinestBands bands;
      std::vector<float> mapped;
      for (std::size_t i = begin; i < end; ++i) {
        const int slice = box.lo[axis] + static_cast<int>(i);
        split_slice(region, channel, axis, slice, box, bands);
        Vec3i at = box.lo;
        at[axis] = slice;
        float* first = &sum[strides.of(at)];
        const int w = box.hi[u] - box.lo[u], h = box.hi[v] - box.lo[v];
        for (std::size_t b = 0; b < kFinishBands; ++b) {
          mapped = bands.band[b];
          maps.bands[k][b].apply(mapped.data(), mapped.size());
          std::size_t n = 0;
          for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x, ++n)
              first[y * strides.step[v] + x * strides.step[u]] += share * (mapped[n] - bands.band[b][n]);
        }
      }
    });
  }
  region.field.channel[c].swap(sum);
  if (measured) maps.values.emplace_back(values_in(*measured, region, channel), finish.values[c]);
  auto& all = region.field.channel[c];
  work.parallel(all.size(), 1 << 16,
                [&](std::size_t b, std::size_t e) { maps.values[0].apply(all.data() + b, e - b); });
  copy_beyond(region.lines, all, work);
}

}  // namespace

void finish_region(const BlockFinish& finish, BlockRegion& region, const Work& work) {
  const std::size_t channels = region.field.channel.size(), rounds = finish.boxes.size();
  if (finish.measured) finish.maps.assign(channels, std::vector<FinishMaps>(rounds));
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t r = 0; r < rounds; ++r) {
      finish_round(finish, c, finish.boxes[r], finish.maps[c][r], region, work.quiet());
      work.done(c * rounds + r + 1, channels * rounds);
    }
}

}  // namespace terrazzo::solids
