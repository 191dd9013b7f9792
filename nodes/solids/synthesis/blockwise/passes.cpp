#include "nodes/solids/synthesis/blockwise/passes.h"

#include <algorithm>
#include <optional>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/blockwise/finish.h"
#include "nodes/solids/synthesis/matching/weights.h"

namespace terrazzo::solids {
namespace {

// Visits the patches that start in a box, in its slices.
template <class Use>
void each_patch(const TorusLines& lines, const NeighborField& f, const TorusBox& box, Use&& use) {
  const std::size_t axis = f.axis;
  const int ua = kSliceColumns[axis], va = kSliceRows[axis];
  const TorusLine &u = lines[ua], &v = lines[va];
  const int i0 = first_patch(box.lo[ua], u.period) - u.first,
            i1 = first_patch(box.hi[ua], u.period) - u.first,
            j0 = first_patch(box.lo[va], v.period) - v.first,
            j1 = first_patch(box.hi[va], v.period) - v.first;
  for (int s = box.lo[f.axis]; s < box.hi[f.axis]; ++s)
    for (int j = j0; j < j1; ++j)
      for (int i = i0; i < i1; ++i)
        use((static_cast<std::size_t>(s - lines[axis].from) * static_cast<std::size_t>(f.rows) +
             static_cast<std::size_t>(j)) *
                f.columns +
            i);
}

// Turns the squared distances of the patches over a box into weights.
void weigh_box(const TorusLines& lines, const TorusBox& box, const WeightTable& table, float floor,
               NeighborField& f, const Work& work) {
  const std::size_t axis = f.axis;
  const int ua = kSliceColumns[axis], va = kSliceRows[axis];
  const auto columns = lines[ua].patches_over(box, ua), rows = lines[va].patches_over(box, va);
  const float inverse = 1 / floor;
  work.parallel(box.hi[f.axis] - box.lo[f.axis], 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s)
      for (int j = rows[0]; j < rows[1]; ++j) {
        float* w = &f.weight[((s + static_cast<std::size_t>(box.lo[f.axis] - lines[axis].from)) *
                                  static_cast<std::size_t>(f.rows) +
                              j) *
                             f.columns];
        for (int i = columns[0]; i < columns[1]; ++i) w[i] = table.of(w[i] * inverse);
      }
  });
}

}  // namespace

BlockPlan block_plan(const TorusBox& wanted, int iterations, int finish_rounds) {
  BlockPlan plan;
  for (int r = finish_rounds - 1; r >= 0; --r) plan.finish.push_back(wanted.grown(r * kFinishReach));
  const TorusBox blended = wanted.grown(finish_rounds * kFinishReach);
  for (int i = iterations; i >= 0; --i) plan.blend.push_back(blended.grown(i * (kPatch - 1)));
  return plan;
}

std::vector<float> values_in(const TorusBox& box, const BlockRegion& region, int channel) {
  std::vector<float> out;
  out.reserve(box.size().cast<double>().prod());
  const Vec3i& size = region.field.size;
  for (int z = box.lo.z(); z < box.hi.z(); ++z)
    for (int y = box.lo.y(); y < box.hi.y(); ++y) {
      const auto row =
          region.field.channel[channel].begin() +
          ((static_cast<std::ptrdiff_t>(z) - region.lines[2].from) * size.y() + y - region.lines[1].from) *
              size.x() -
          region.lines[0].from;
      out.insert(out.end(), row + box.lo.x(), row + box.hi.x());
    }
  return out;
}

void measure_values(BlockProbe& probe, const BlockRegion& region, const Work& work) {
  std::vector<std::optional<ValueMap>> fixed(region.field.channel.size());
  work.parallel(fixed.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      fixed[c].emplace(values_in(probe.box, region, c), probe.values[c]);
  });
  auto& maps = probe.measured.values.emplace_back();
  for (const auto& m : fixed) maps.push_back(*m);
}

void measure_floors(BlockProbe& probe, const BlockRegion& region) {
  auto& floors = probe.measured.floor.emplace_back();
  for (const NeighborField& f : region.families) {
    double sum = 0, n = 0;
    each_patch(region.lines, f, probe.box, [&](std::size_t p) {
      sum += f.weight[p];
      ++n;
    });
    floors.push_back(std::max(sum / n, 1e-12));
  }
}

void blend_pass(const BlockPasses& passes, std::size_t blend, BlockProbe* probe, BlendSources* sources,
                const std::vector<const std::vector<Vec3f>*>& features, BlockRegion& region,
                const Work& work) {
  const TorusBox& box = passes.plan.blend[blend];
  BlendRange range;
  for (int a = 0; a < 3; ++a) {
    const TorusLine& l = region.lines[a];
    range.covers[a] = &l.cover;
    range.lo[a] = box.lo[a] - l.from;
    range.hi[a] = box.hi[a] - l.from;
  }
  blend_patches(passes.exemplars, region.families, {passes.windows[blend]}, range, region.field, sources,
                &features, work);
  auto& channels = region.field.channel;
  if (probe) measure_values(*probe, region, work.quiet());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    work.quiet().parallel(channels[c].size(), 1 << 16, [&](std::size_t b, std::size_t e) {
      passes.statistics.values[blend][c].apply(channels[c].data() + b, e - b);
    });
    copy_beyond(region.lines, channels[c], work.quiet());
  }
}

void run_passes(const BlockPasses& passes, bool to_blend, BlockProbe* probe, BlendSources* sources,
                const std::vector<const std::vector<Vec3f>*>& features, BlockRegion& region,
                const Work& work) {
  const WeightTable weights(passes.power);
  blend_pass(passes, 0, probe, nullptr, features, region, work.part(0, 0.1));
  const int rounds = count_of(passes.plan.blend) - 1;
  for (int i = 0; i < rounds; ++i) {
    const std::size_t k = i;
    const Work step = work.part(0.1 + 0.9 * i / rounds, 0.1 + 0.9 * (i + 1) / rounds);
    const TorusBox& box = passes.plan.blend[k + 1];
    SearchOptions search = passes.search;
    search.iteration += i;
    search_locally(passes.exemplars, passes.statistics.penalty, box, search, region, step.part(0, 0.6));
    if (probe) measure_floors(*probe, region);
    for (std::size_t f = 0; f < region.families.size(); ++f) {
      weigh_box(region.lines, box, weights, passes.statistics.floor[k][f], region.families[f], work.quiet());
      copy_beyond(region.lines, region.families[f], work.quiet());
    }
    const bool last = i + 1 == rounds;
    if (last && !to_blend) return;
    blend_pass(passes, k + 1, probe, last ? sources : nullptr, features, region, step.part(0.6, 1));
  }
}

}  // namespace terrazzo::solids
