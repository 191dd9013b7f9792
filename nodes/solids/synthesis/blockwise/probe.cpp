// Statistics that are fixed before any part is made.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/blockwise/level.h"

namespace terrazzo::solids {
namespace {

// The fraction of a level's voxels with smaller values, from a table of its distribution.
double rank_in(const Quantiles& q, float value) {
  const auto above = std::upper_bound(q.at.begin(), q.at.end(), value);
  if (above == q.at.begin()) return 0;
  if (above == q.at.end()) return 1;
  const float lo = *(above - 1), hi = *above;
  return (static_cast<double>(above - q.at.begin()) - 1 + (value - lo) / (hi - lo)) / (q.at.size() - 1);
}

// The target distribution of the values in the probe. On the level below, the probe's values (`here`) differ
// from the whole level's (`coarse`); the target keeps that difference. Otherwise the whole solid would
// deviate from its exemplar by whatever the probe happens to contain.
Quantiles as_here(const Quantiles& wanted, const Quantiles& here, const Quantiles& coarse, bool everywhere) {
  Quantiles q = wanted;
  if (everywhere) return q;
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < q.at.size(); ++i) {
    q.at[i] = wanted.of(rank_in(coarse, here.at[i]));
    sum += q.at[i];
    squares += static_cast<double>(q.at[i]) * q.at[i];
  }
  q.mean = sum / q.at.size();
  q.deviation = std::sqrt(std::max(0.0, squares / q.at.size() - q.mean * q.mean));
  return q;
}

// Per exemplar and texel, the penalty on patches that these families use more often than average.
std::vector<std::vector<float>> penalties_of(const std::vector<const ExemplarLevel*>& exemplars,
                                             const std::vector<NeighborField>& families, double overuse) {
  std::vector<std::vector<float>> out;
  for (std::size_t e = 0; e < exemplars.size(); ++e) {
    std::vector<double> count(exemplars[e]->usable.size(), 0);
    double all = 0;
    for (const auto& f : families)
      if (f.exemplar == static_cast<int>(e))
        for (const auto at : f.at) {
          ++count[at];
          ++all;
        }
    const double mean = std::max(all / exemplars[e]->starts.size(), 1e-9);
    out.emplace_back();
    for (const double n : count) out.back().push_back(1 + overuse * std::max(0.0, n / mean - 1));
  }
  return out;
}

// The same at a finer level: each patch gets the penalty of the coarse patch at its place.
std::vector<float> finer_penalties(const std::vector<float>& coarse, const ExemplarLevel& from,
                                   const ExemplarLevel& to) {
  std::vector<float> out(to.usable.size(), 1.0f);
  const auto place = [](int start, int width, int coarse_width) {
    const double p = (start + kPatch / 2.0) * coarse_width / width - kPatch / 2.0;
    return std::clamp(round_down(p + 0.5), 0, coarse_width - kPatch);
  };
  for (const auto start : to.starts) {
    const int x = place(static_cast<int>(start) % to.width, to.width, from.width),
              y = place(static_cast<int>(start) / to.width, to.height, from.height);
    out[start] = coarse[pixel_at(x, y, from.width)];
  }
  return out;
}

}  // namespace

TorusBox probe_box(const Vec3i& level, const BlockwiseLimits& limits) {
  TorusBox box;
  for (int a = 0; a < 3; ++a) {
    box.closed[a] = level[a] <= limits.closed;
    box.hi[a] = level[a] <= limits.closed ? level[a] : limits.probe;
  }
  return box;
}

TorusBox BlockLevels::core_below(int level, const TorusBox& core) const {
  TorusBox box;
  for (int a = 0; a < 3; ++a) box.hi[a] = core.hi[a] * size(level - 1)[a] / size(level)[a];
  return box;
}

BlockLevels::Targets BlockLevels::targets_in(int level, const TorusBox& core, const Below& below) const {
  const auto wanted = level_values(level_of(pyramids_, level), settings_, channels_),
             coarse = level_values(level_of(pyramids_, level - 1), settings_, channels_);
  const TorusBox box = core_below(level, core);
  const Vec3i from = size(level - 1);
  const bool everywhere = core.closed == std::array{true, true, true};
  Targets out;
  for (int c = 0; c < channels_; ++c) {
    const std::size_t k = c;
    std::vector<float> values;
    if (below.whole) {
      const auto& v = whole_.field.channel[k];
      for (int z = 0; z < box.hi.z(); ++z)
        for (int y = 0; y < box.hi.y(); ++y) {
          const auto row = v.begin() + (static_cast<std::ptrdiff_t>(z) * from.y() + y) * from.x();
          values.insert(values.end(), row, row + box.hi.x());
        }
    } else {
      values = values_in(box, below.made, c);
    }
    const Quantiles here = quantiles_of(values);
    out.values.push_back(as_here(wanted[k], here, coarse[k], everywhere));
    out.finished.push_back(as_here(finished_[k], here, coarse[k], everywhere));
  }
  return out;
}

std::optional<BlockRegion> BlockLevels::measure(BlendSources* sources, const Work& work) {
  const auto coarse = penalties_of(level_of(pyramids_, whole_.level), whole_.families, settings_.overuse);
  std::optional<BlockRegion> everywhere;
  for (int level = whole_.level + 1; level < levels_; ++level) {
    LevelStatistics& s = statistics_[level];
    for (std::size_t e = 0; e < pyramids_.size(); ++e)
      s.penalty.push_back(finer_penalties(coarse[e], pyramids_[e][whole_.level], pyramids_[e][level]));
    const TorusBox core = probe_box(size(level), settings_.blockwise_limits);
    const double n = levels_ - 1 - whole_.level;
    const bool last = level + 1 == levels_, all = last && core.closed == std::array{true, true, true};
    BlockRegion probe =
        run(level, core, last ? Upto::Finish : Upto::Blend, s, &s, &core, all ? sources : nullptr,
            work.part((level - whole_.level - 1) / n, (level - whole_.level) / n));
    if (all) everywhere = std::move(probe);
  }
  return everywhere;
}

}  // namespace terrazzo::solids
