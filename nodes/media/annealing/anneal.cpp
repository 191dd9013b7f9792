#include "nodes/media/annealing/anneal.h"

#include <fmt/format.h>

#include <algorithm>

#include "nodes/data/indices.h"
#include "nodes/media/annealing/block.h"
#include "nodes/media/annealing/descent.h"

namespace terrazzo::annealing {
namespace {
using media::PhaseMap;

constexpr int kCoarse = 4;  // finer levels are made in slabs

std::string note(const Vec3i& size) {
  return fmt::format("{} × {} × {} voxels", size.x(), size.y(), size.z());
}

// Makes all layers of the levels in `strides`, the first of them from `slab`, or from noise if it is empty.
Solid descend(Descent& descent, const std::vector<int>& strides, Slab slab, int stride_of_slab,
              std::uint64_t seed, const Work& work) {
  Solid out;
  double all = 0, until = 0;
  for (const int stride : strides) all += visits(stride);
  for (const int stride : strides) {
    slab = slab.phase.empty()
               ? descent.noise(stride)
               : descent.enlarge(slab, stride_of_slab, stride, {0, descent.size_at(stride).z()});
    stride_of_slab = stride;
    const Work part = work.part(until, until + visits(stride) / all);
    until += visits(stride) / all;
    part.progress(0, note(slab.size));
    std::vector<std::int64_t> count;
    if (stride == 1) count = descent.counts(static_cast<std::int64_t>(voxels_in(slab.size)));
    out.levels.push_back(descent.anneal(slab, stride, Ends::Tile, seed, count, part));
  }
  out.phase = std::move(slab.phase);
  return out;
}

std::vector<int> strides_where(const Descent& descent, bool coarse) {
  auto out = descent.strides();
  std::erase_if(out, [&](int stride) { return (stride >= kCoarse) != coarse; });
  return out;
}

}  // namespace

Solid synthesize(const std::vector<PhaseMap>& pictures, const AnnealOptions& options, const Work& work) {
  Descent descent(pictures, options);
  return descend(descent, descent.strides(), {}, 0, options.seed, work);
}

CoarseSolid synthesize_coarse(const std::vector<PhaseMap>& pictures, const AnnealOptions& options,
                              const Work& work) {
  Descent descent(pictures, options);
  const auto strides = strides_where(descent, true);
  return {strides.back(), descent.size_at(strides.back()),
          descend(descent, strides, {}, 0, options.seed, work).phase};
}

Solid synthesize_block(const std::vector<PhaseMap>& pictures, const AnnealOptions& options,
                       const CoarseSolid& coarse, int blocks, int block, const Work& work) {
  Descent descent(pictures, options);
  const auto strides = strides_where(descent, false);
  if (blocks == 1)
    return descend(descent, strides, {0, coarse.size, coarse.phase}, coarse.stride, options.seed, work);
  Block made(descent, coarse, blocks, block, options.seed);
  Solid out;
  double done = 0;
  for (const int stride : strides) {
    const double share = visits(stride) / (visits(2) + visits(1));
    out.levels.push_back(made.refine(stride, work.part(done, done + share)));
    done += share;
  }
  out.phase = part_of(made.slab(), layers_of(blocks, block, options.size.z())).phase;
  return out;
}

Layers layers_of(int blocks, int block, int layers) {
  const auto cut = [&](std::int64_t k) { return static_cast<int>(k * layers / blocks); };
  return {cut(block), cut(block + 1) - cut(block)};
}

double memory_forecast(const Vec3i& size) {
  // The phases, their coarser copy and bits, the list of voxels at interfaces, which is copied once, and the
  // grids.
  return 30.0 * static_cast<double>(voxels_in(size)) + 64e6;
}

double coarse_forecast(const Vec3i& size) { return memory_forecast(size_at(size, kCoarse)); }

double block_forecast(const Vec3i& size, int blocks) {
  const int layers = (size.z() + blocks - 1) / blocks + (blocks > 1 ? 2 * Block::kSeam : 0);
  const double copies = 4;  // of the coarse solid
  return memory_forecast({size.x(), size.y(), layers}) +
         copies * static_cast<double>(voxels_in(size_at(size, kCoarse)));
}

}  // namespace terrazzo::annealing
