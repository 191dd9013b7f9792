#include "nodes/solids/synthesis/blockwise/level.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/common/texture/band_statistics.h"
#include "nodes/data/indices.h"

namespace terrazzo::solids {
TorusBox box_below(const TorusBox& part, const Vec3i& level, const Vec3i& below) {
  TorusBox out;
  out.closed = part.closed;
  for (int a = 0; a < 3; ++a) {
    if (part.closed[a]) {
      out.lo[a] = 0;
      out.hi[a] = below[a];
      continue;
    }
    const int first = patch_start(first_patch(part.lo[a] - kPatch + 1, level[a]), level[a]),
              last = patch_start(first_patch(part.hi[a], level[a]) - 1, level[a]);
    double miss;
    const int lo = patch_start(patch_below(first, level[a], below[a], miss), below[a]),
              hi = patch_start(patch_below(last, level[a], below[a], miss), below[a]);
    out.lo[a] = std::min(lo + kPatch - 1, slices_below(part.lo[a], level[a], below[a])[0]);
    out.hi[a] = std::max(hi, slices_below(part.hi[a] - 1, level[a], below[a])[1]) + 1;
  }
  return out;
}

BlockLevels::BlockLevels(const std::vector<SolidExemplar>& working, const std::vector<Pyramid>& pyramids,
                         const SolidOptions& s, const std::vector<int>& iterations, int channels,
                         const WholeLevel& whole, BlockGl* gl)
    : gl_(gl),
      working_(working),
      pyramids_(pyramids),
      settings_(s),
      iterations_(iterations),
      whole_(whole),
      levels_(count_of(iterations)),
      channels_(channels),
      statistics_(iterations.size()) {
  for (const auto& e : working) bands_.push_back(finest_bands(e, channels_));
  std::vector<BandStatistics> pictures;
  for (const auto& e : working) {
    Image picture(e.width, e.height, 1, 1);
    picture.pixels = e.pixels;
    pictures.push_back(measure_bands(picture, channels_, 1, Work()));
  }
  for (int c = 0; c < channels_; ++c) {
    std::vector<const Quantiles*> planes;
    for (const int p : s.plane)
      if (p >= 0) planes.push_back(&pictures[p].values[c]);
    finished_.push_back(mixture(planes));
  }
}

Vec3i BlockLevels::size(int level) const { return box_at(settings_.size, level, levels_); }

int BlockLevels::Below::patch(int axis, int number) const {
  const TorusLine& l = lines[axis];
  if (whole) return wrapped(number, patches_around(l.period));
  return (l.closed ? wrapped(number, patches_around(l.period)) : number) - l.first;
}

int BlockLevels::Below::slice(int axis, int voxel) const {
  const TorusLine& l = lines[axis];
  if (whole) return wrapped(voxel, l.period);
  return (l.closed ? wrapped(voxel, l.period) : voxel) - l.from;
}

BlockLevels::Below BlockLevels::below(int level, const TorusBox& part, const TorusBox* core,
                                      const Work& work) const {
  Below out;
  out.whole = level - 1 == whole_.level;
  if (out.whole) {
    TorusBox all;
    all.hi = size(level - 1);
    all.closed = {true, true, true};
    out.lines = torus_lines(all, all.hi);
    return out;
  }
  TorusBox needed = box_below(part, size(level), size(level - 1));
  if (core) {
    const TorusBox there = core_below(level, *core);
    needed.lo = needed.lo.cwiseMin(there.lo);
    needed.hi = needed.hi.cwiseMax(there.hi);
  }
  const LevelStatistics& s = statistics_[level - 1];
  out.made = run(level - 1, needed, core ? Upto::Blend : Upto::Matches, s, nullptr, nullptr, nullptr, work);
  out.lines = out.made.lines;
  return out;
}

void BlockLevels::carry(int level, const Below& below, BlockRegion& region, const Work& work) const {
  const Vec3i from = size(level - 1);
  std::array<CarriedPatches, 3> patches;
  std::array<std::vector<std::array<int, 2>>, 3> slices;
  std::array<std::vector<int>, 3> number;
  for (int a = 0; a < 3; ++a) {
    const std::size_t k = a;
    const TorusLine& l = region.lines[k];
    CarriedPatches& c = patches[k];
    c.around = patches_around(l.period);
    c.miss.resize(l.start.size());
    for (int i = 0; i < l.patches(); ++i) {
      // On a closed axis copies use the same source as their originals.
      const int q = l.closed ? wrapped(l.first + i, c.around) : l.first + i;
      c.number.push_back(wrapped(q, c.around));
      c.from.push_back(below.patch(a, patch_below(patch_start(q, l.period), l.period, from[a], c.miss[i])));
    }
    for (int v = l.from; v < l.to; ++v) {
      const int voxel = l.closed ? wrapped(v, l.period) : v;
      slices[k].push_back(slices_below(voxel, l.period, from[a]));
      for (int& s : slices[k].back()) s = below.slice(a, s);
      number[k].push_back(wrapped(voxel, l.period));
    }
  }
  const auto& families = below.whole ? whole_.families : below.made.families;
  for (const NeighborField& old : families) {
    const std::size_t axis = old.axis;
    const Pyramid& p = pyramids_[old.exemplar];
    region.families.push_back(block_family(region.lines, old.axis, old.exemplar));
    carry_matches(old, patches[kSliceColumns[axis]], patches[kSliceRows[axis]], slices[axis], number[axis],
                  p[level - 1], p[level], settings_.seed, region.families.back(), work);
  }
}

BlockRegion BlockLevels::run(int level, const TorusBox& wanted, Upto upto, const LevelStatistics& fixed,
                             LevelStatistics* measured, const TorusBox* core, BlendSources* sources,
                             const Work& work) const {
  const int rounds = iterations_[level];
  const BlockPlan plan = block_plan(wanted, rounds, upto == Upto::Finish ? settings_.finish : 0);
  BlockRegion region;
  region.lines = torus_lines(plan.blend[0], size(level));
  Targets targets;
  const auto tell = [&](double done, const char* what) {
    work.progress(done, fmt::format("level {} of {}: {}", level + 1, levels_, what));
  };
  {
    const Below source = below(level, plan.blend[0], core, work.part(0, 0.3));
    tell(0.3, "carry");
    carry(level, source, region, work.quiet());
    if (core) targets = targets_in(level, *core, source);
  }
  const Work own = work.part(0.3, 1);
  const auto exemplars = level_of(pyramids_, level);
  for (int a = 0; a < 3; ++a) {
    const TorusLine& l = region.lines[a];
    region.field.size[a] = l.to - l.from;
  }
  region.field.channel.resize(channels_);
  work.quiet().parallel(region.field.channel.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) region.field.channel[c].resize(voxels(region.field.size));
  });
  const LevelStatistics& known = measured ? *measured : fixed;
  std::vector<float> windows = {static_cast<float>(10 * settings_.window)};
  for (int i = 0; i < rounds; ++i) {
    const double fall = rounds > 1 ? static_cast<double>(i) / (rounds - 1) : 1;
    windows.push_back(settings_.window * std::pow(10, 1 - fall));
  }
  SearchOptions search = search_settings(settings_);
  search.iteration = std::accumulate(iterations_.begin(), iterations_.begin() + level, 0);
  const BlockPasses passes{exemplars, known, plan, windows, search, (settings_.exponent - 2) / 2};
  std::vector<const std::vector<Vec3f>*> features;
  if (sources) {
    sources->texel.resize(voxels(region.field.size));
    sources->exemplar.resize(voxels(region.field.size));
    bool any = false;
    for (const auto& e : working_) {
      features.push_back(&e.features);
      any |= !e.features.empty();
    }
    if (any) sources->features.assign(voxels(region.field.size), Vec3f::Zero());
  }
  const bool to_blend = upto != Upto::Matches;
  std::optional<BlockProbe> probe;
  if (core) probe.emplace(BlockProbe{*core, targets.values, *measured});
  BlockProbe* const measuring = probe ? &*probe : nullptr;
  tell(0.3, gl_ ? "upload" : "match");
  std::vector<std::vector<FinishMaps>> maps = known.finish;
  const BlockFinish finish{bands_, plan.finish, core ? measured->finish : maps, core, targets.finished};
  // The device cannot keep sources: then the last blend and the finish run on the processor.
  const bool finished = gl_ && !sources && !plan.finish.empty();
  if (gl_) {
    gl_->run(passes, to_blend && !sources, measuring, finished ? &finish : nullptr, region, own.part(0, 0.8));
    if (sources)
      blend_pass(passes, plan.blend.size() - 1, measuring, sources, features, region, work.quiet());
  } else {
    run_passes(passes, to_blend, measuring, sources, features, region, own.part(0, 0.8));
  }
  if (finished || plan.finish.empty()) return region;
  tell(0.86, "finish");
  finish_region(finish, region, own.part(0.8, 1));
  return region;
}

BlockRegion BlockLevels::make(const TorusBox& box, BlendSources* sources, const Work& work) const {
  return run(levels_ - 1, box, Upto::Finish, statistics_.back(), nullptr, nullptr, sources, work);
}

}  // namespace terrazzo::solids
