#include "nodes/solids/synthesis/optimize_solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/texture/quantiles.h"
#include "nodes/solids/synthesis/blockwise/blocks.h"
#include "nodes/solids/synthesis/exemplar/guide.h"
#include "nodes/solids/synthesis/exemplar/patch_tree.h"
#include "nodes/solids/synthesis/reference_2011/optimize.h"
#include "nodes/solids/synthesis/whole/finish.h"
#include "nodes/solids/synthesis/whole/measures.h"
#include "runtime/random.h"

namespace terrazzo::solids {
namespace {

constexpr int kExhaustiveEvery = 3;
constexpr int kGuideReach = 10;  // pixels
// Dimensions of patch vectors. The finest level needs fewer because its matches are already in place: quality
// is unchanged and a tenth less is copied. With fewer dimensions on all levels, bricks turn into stripes.
constexpr int kDims = 32, kLastDims = 16;

void match_all(SolidField& field, const std::vector<Quantiles>& targets, const Work& work) {
  for (std::size_t c = 0; c < targets.size(); ++c) match_values(field.channel[c], targets[c], work.quiet());
}

// Start from random texels, so that every voxel has a color of the exemplar.
void random_texels(SolidField& field, const ExemplarLevel& e, std::uint64_t seed) {
  for (std::size_t i = 0; i < field.channel[0].size(); ++i) {
    const std::size_t texel = e.starts[Random(seed, 0x10, i).below(e.starts.size())];
    for (std::size_t c = 0; c < field.channel.size(); ++c) field.channel[c][i] = e.texels[4 * texel + c];
  }
}

std::vector<NeighborField> random_families(const Vec3i& size,
                                           const std::vector<const ExemplarLevel*>& exemplars,
                                           const SolidOptions& s) {
  std::vector<NeighborField> out;
  for (int a = 0; a < 3; ++a)
    if (const int p = s.plane[a]; p >= 0) out.push_back(random_matches(size, a, p, *exemplars[p], s.seed));
  return out;
}

// Iterations per level, and the fraction of the work done by the end of each level, weighted by voxels
// visited.
struct Schedule {
  std::vector<int> iterations;
  std::vector<double> end;
  Schedule(const SolidOptions& s, int levels) {
    double sum = 0;
    for (int l = 0; l < levels; ++l) {
      iterations.push_back(s.iterations[std::min<std::size_t>(l, s.iterations.size() - 1)]);
      end.push_back(sum += iterations.back() * std::pow(8.0, l));
    }
    for (auto& e : end) e /= sum;
  }
  Work part(const Work& work, int level, int from, int to) const {
    const double a = level > 0 ? end[level - 1] : 0, b = end[level];
    const double n = iterations[level];
    return work.part(a + (b - a) * from / n, a + (b - a) * to / n);
  }
};

// Runs all levels up to and including the finest one that is made whole.
std::vector<NeighborField> by_coherence(const std::vector<SolidExemplar>& exemplars,
                                        std::vector<Pyramid>& pyramids, const SolidOptions& s,
                                        SolidResult& out, const Work& work) {
  const int levels = out.levels, made = whole_level(s, levels) + 1;
  const Schedule schedule(s, made);
  std::vector<NeighborField> families;
  SolidField& field = out.field;
  int iteration = 0;
  for (int level = 0; level < made; ++level) {
    const Vec3i size = box_at(s.size, level, levels);
    schedule.part(work, level, 0, 1).progress(0, fmt::format("level {} of {}: whole", level + 1, levels));
    for (auto& p : pyramids) find_similar(p[level], work.quiet());
    const auto at_level = level_of(pyramids, level);
    const int channels = at_level[0]->channels;
    const auto targets = level_values(at_level, s, channels);
    field.size = size;
    field.channel.assign(channels, std::vector<float>(voxels(size)));
    if (level == 0) {
      random_texels(field, *at_level[0], s.seed);
      families = random_families(size, at_level, s);
    } else {
      for (auto& f : families) {
        const Pyramid& p = pyramids[f.exemplar];
        f = carry_up(f, box_at(s.size, level - 1, levels), size, p[level - 1], p[level], s.seed,
                     work.quiet());
      }
      blend_patches(at_level, families, {static_cast<float>(10 * s.window)}, field, nullptr, nullptr,
                    work.quiet());
      match_all(field, targets, work);
    }
    const int rounds = schedule.iterations[level];
    for (int i = 0; i < rounds; ++i, ++iteration) {
      const Work step = schedule.part(work, level, i, i + 1);
      SearchOptions search = search_settings(s);
      search.iteration = iteration;
      // Try all patches only now and then: between, coherence search finds matches as good.
      search.exhaustive = level == 0 && at_level[0]->starts.size() <= 2000 && i % kExhaustiveEvery == 0;
      search_matches(field, at_level, families, search, step.part(0, 0.6));
      for (auto& f : families) weigh(f, s.exponent, work.quiet());
      const double fall = rounds > 1 ? static_cast<double>(i) / (rounds - 1) : 1;
      const BlendOptions blend{static_cast<float>(s.window * std::pow(10, 1 - fall))};
      BlendSources* sources = nullptr;
      std::vector<const std::vector<Vec3f>*> features;
      if (s.sources && level == levels - 1 && i == rounds - 1) {
        sources = &out.sources;
        sources->texel.resize(voxels(size));
        sources->exemplar.resize(voxels(size));
        bool any = false;
        for (const auto& e : exemplars) {
          features.push_back(&e.features);
          any |= !e.features.empty();
        }
        if (any) sources->features.assign(voxels(size), Vec3f::Zero());
      }
      blend_patches(at_level, families, blend, field, sources, &features, step.part(0.6, 0.95));
      match_all(field, targets, work);
      step.progress(1);
    }
  }
  field.channel.resize(out.axes.channels);
  return families;
}

void by_reference(const std::vector<Pyramid>& pyramids, const SolidOptions& s, SolidResult& out,
                  const Work& work) {
  const Schedule schedule(s, out.levels);
  // The paper's windows, for colors in [0, 1]. All levels between the first and the last share the second.
  constexpr double kWindows[3] = {10, 0.05, 0.01};
  std::vector<NeighborField> families;
  for (int level = 0; level < out.levels; ++level) {
    const Vec3i size = box_at(s.size, level, out.levels);
    const auto at_level = level_of(pyramids, level);
    if (level == 0) {
      out.field.size = size;
      out.field.channel.assign(out.axes.channels, std::vector<float>(voxels(size)));
      random_texels(out.field, *at_level[0], s.seed);
    } else {
      out.field = resample(out.field, size, work.quiet());
    }
    families = random_families(size, at_level, s);
    const int rounds = schedule.iterations[level];
    optimize_by_reference(at_level, families, rounds, s.exponent,
                          kWindows[level == 0               ? 0
                                   : level + 1 < out.levels ? 1
                                                            : 2] *
                              out.axes.scale,
                          s.seed, out.field, schedule.part(work, level, 0, rounds));
  }
  out.measures = measure_copies(families, work.quiet());
}

// The first steps, common to every method.
struct Prepared {
  std::vector<SolidExemplar> working;  // in the working axes
  std::vector<Pyramid> pyramids;
  SolidResult out;  // its axes and levels
};

Prepared prepare(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s, const Work& work) {
  Prepared p;
  SolidResult& out = p.out;
  out.size = s.size;
  std::vector<const std::vector<Vec3f>*> pictures;
  for (const auto& e : exemplars) pictures.push_back(&e.pixels);
  out.axes = color_axes(pictures, s.color);
  const int channels = out.axes.channels;
  if (channels == 0)
    throw Error("one-color", "the exemplar has a single color", "use an exemplar with visible texture");
  p.working = exemplars;
  for (auto& e : p.working)
    for (auto& pixel : e.pixels) pixel = out.axes.to(pixel);

  const int levels = out.levels = s.levels > 0 ? s.levels : natural_levels(exemplars, s.size);
  if (s.method == SolidMethod::Blockwise && levels < 2)
    throw Error(
        "bad-value",
        "method blockwise needs at least two levels, since it makes the coarser ones whole; levels is 1",
        "set method: coherence, or use a larger exemplar")
        .parameter("levels");
  for (const auto& e : exemplars)
    if (s.method == SolidMethod::Blockwise && std::min(e.width, e.height) < kFinishLeast)
      throw Error(
          "exemplar-too-small",
          fmt::format("{} × {} pixels are too few for the finish of method blockwise", e.width, e.height),
          fmt::format("use at least {0} × {0} pixels, or set method: coherence", kFinishLeast));
  const int guided = guided_levels(s, levels);
  if (guided > 0) guide_by_phases(p.working, s.guide, kGuideReach);
  for (auto& e : p.working)
    p.pyramids.push_back(
        s.method == SolidMethod::Reference
            ? exemplar_levels(e, channels, guided, levels, 0.95, PatchTree::kMostDims, PatchTree::kMostDims,
                              work.quiet())
            : exemplar_levels(e, channels, guided, levels, 0.98, kDims, kLastDims, work.quiet()));
  return p;
}

}  // namespace

SolidResult optimize_solid(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s,
                           const Work& work, BlockGl* gl) {
  auto [working, pyramids, out] = prepare(exemplars, s, work);
  if (s.method == SolidMethod::Reference)
    by_reference(pyramids, s, out, work.part(0, 0.97));
  else if (s.method == SolidMethod::Blockwise)
    make_block(working, pyramids, by_coherence(working, pyramids, s, out, work.part(0, 0.3)), s, gl, out,
               work.part(0.3, 0.97));
  else
    out.measures = measure_copies(
        by_coherence(exemplars, pyramids, s, out, work.part(0, s.finish > 0 ? 0.85 : 0.97)), work.quiet());
  pyramids.clear();
  if (s.finish > 0 && s.method == SolidMethod::Coherence)
    finish_bands(working, s, out.field, work.part(0.85, 0.97));
  if (!s.measured) return std::move(out);
  work.progress(0.97, "measures");
  measure_planes(working, s, out.field, out.measures, work.part(0.97, 1));
  return std::move(out);
}

BlockBase solid_base(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s, const Work& work) {
  auto [working, pyramids, out] = prepare(exemplars, s, work);
  auto families = by_coherence(working, pyramids, s, out, work.part(0, 0.6));
  return measure_base(working, pyramids, std::move(families), s, out, work.part(0.6, 1));
}

SolidResult solid_block(const std::vector<SolidExemplar>& exemplars, const SolidOptions& s,
                        const BlockBase& base, const Work& work, BlockGl* gl) {
  auto [working, pyramids, out] = prepare(exemplars, s, work);
  make_block(working, pyramids, base, s, gl, out, work.part(0, 0.97));
  pyramids.clear();
  work.progress(0.97, "measures");
  measure_planes(working, s, out.field, out.measures, work.part(0.97, 1));
  return std::move(out);
}

}  // namespace terrazzo::solids
