#include "nodes/solid_optimize/local_level.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nodes/common/band_statistics.h"
#include "nodes/common/slice_axes.h"
#include "nodes/solid_optimize/weights.h"

namespace terrazzo::solid_optimize {
namespace {

// The share of a level's voxels that have smaller values, by a table of its distribution.
double rank_in(const Quantiles& q, float value) {
  const auto above = std::upper_bound(q.at.begin(), q.at.end(), value);
  if (above == q.at.begin()) return 0;
  if (above == q.at.end()) return 1;
  const float lo = *(above - 1), hi = *above;
  return (static_cast<double>(above - q.at.begin()) - 1 + (value - lo) / (hi - lo)) /
         static_cast<double>(q.at.size() - 1);
}

// What the values in the probe should be distributed as: not as the whole level's, but as far from it as those
// of the level below are, `here`, from theirs in the whole. Otherwise all of a solid would differ from its
// exemplar by what the probe happens to show.
Quantiles as_here(const Quantiles& wanted, const Quantiles& here, const Quantiles& coarse, bool everywhere) {
  Quantiles q = wanted;
  if (everywhere) return q;
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < q.at.size(); ++i) {
    q.at[i] = wanted.of(rank_in(coarse, here.at[i]));
    sum += q.at[i], squares += static_cast<double>(q.at[i]) * q.at[i];
  }
  q.mean = sum / static_cast<double>(q.at.size());
  q.deviation = std::sqrt(std::max(0.0, squares / static_cast<double>(q.at.size()) - q.mean * q.mean));
  return q;
}

// As many of the patches as start in a box, in slices of it.
template <class Use>
void each_patch(const LocalLines& lines, const MatchFamily& f, const LocalBox& box, Use&& use) {
  const std::size_t axis = static_cast<std::size_t>(f.axis);
  const int ua = kSliceColumns[axis], va = kSliceRows[axis];
  const LocalLine &u = lines[static_cast<std::size_t>(ua)], &v = lines[static_cast<std::size_t>(va)];
  const int i0 = first_patch(box.lo[ua], u.period) - u.first, i1 = first_patch(box.hi[ua], u.period) - u.first,
            j0 = first_patch(box.lo[va], v.period) - v.first, j1 = first_patch(box.hi[va], v.period) - v.first;
  for (int s = box.lo[f.axis]; s < box.hi[f.axis]; ++s)
    for (int j = j0; j < j1; ++j)
      for (int i = i0; i < i1; ++i)
        use((static_cast<std::size_t>(s - lines[axis].from) * static_cast<std::size_t>(f.rows) +
             static_cast<std::size_t>(j)) *
                static_cast<std::size_t>(f.columns) +
            static_cast<std::size_t>(i));
}

// Squared distances of the patches over a box become weights.
void weigh_box(const LocalLines& lines, const LocalBox& box, const WeightTable& table, float floor,
               MatchFamily& f, const Work& work) {
  const std::size_t axis = static_cast<std::size_t>(f.axis);
  const int ua = kSliceColumns[axis], va = kSliceRows[axis];
  const auto columns = lines[static_cast<std::size_t>(ua)].patches_over(box, ua),
             rows = lines[static_cast<std::size_t>(va)].patches_over(box, va);
  const float inverse = 1 / floor;
  work.parallel(static_cast<std::size_t>(box.hi[f.axis] - box.lo[f.axis]), 4,
                [&](std::size_t begin, std::size_t end) {
                  for (std::size_t s = begin; s < end; ++s)
                    for (int j = rows[0]; j < rows[1]; ++j) {
                      float* w = &f.weight[((s + static_cast<std::size_t>(box.lo[f.axis] - lines[axis].from)) *
                                                static_cast<std::size_t>(f.rows) +
                                            static_cast<std::size_t>(j)) *
                                           static_cast<std::size_t>(f.columns)];
                      for (int i = columns[0]; i < columns[1]; ++i) w[i] = table.of(w[i] * inverse);
                    }
                });
}

}  // namespace

LocalPlan local_plan(const LocalBox& wanted, int iterations, int finish_rounds) {
  LocalPlan plan;
  for (int r = finish_rounds - 1; r >= 0; --r) plan.finish.push_back(wanted.grown(r * kFinishReach));
  const LocalBox blended = wanted.grown(finish_rounds * kFinishReach);
  for (int i = iterations; i >= 0; --i) plan.blend.push_back(blended.grown(i * (kPatch - 1)));
  return plan;
}

LocalBox box_below(const LocalBox& part, const Vec3i& level, const Vec3i& below) {
  LocalBox out;
  out.closed = part.closed;
  for (int a = 0; a < 3; ++a) {
    if (part.closed[static_cast<std::size_t>(a)]) {
      out.lo[a] = 0, out.hi[a] = below[a];
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

LocalBox probe_box(const Vec3i& level, const LocalLimits& limits) {
  LocalBox box;
  for (int a = 0; a < 3; ++a) {
    box.closed[static_cast<std::size_t>(a)] = level[a] <= limits.closed;
    box.hi[a] = level[a] <= limits.closed ? level[a] : limits.probe;
  }
  return box;
}

LocalLevels::LocalLevels(const std::vector<SolidExemplar>& working, const std::vector<Pyramid>& pyramids,
                         const SolidSettings& s, const std::vector<int>& iterations, WholeLevel&& whole, LocalGl* gl)
    : gl_(gl),
      working_(working),
      pyramids_(pyramids),
      settings_(s),
      iterations_(iterations),
      whole_(std::move(whole)),
      levels_(static_cast<int>(iterations.size())),
      channels_(static_cast<int>(whole_.field.channel.size())),
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
      if (p >= 0) planes.push_back(&pictures[static_cast<std::size_t>(p)].values[static_cast<std::size_t>(c)]);
    finished_.push_back(mixture(planes));
  }
}

// Of the mean shift after an iteration; −1: after matches are carried up.
float LocalLevels::window_at(int iteration, int rounds) const {
  const double fall = iteration < 0 ? 0 : rounds > 1 ? static_cast<double>(iteration) / (rounds - 1) : 1;
  return static_cast<float>(settings_.window * std::pow(10, 1 - fall));
}

Vec3i LocalLevels::size(int level) const { return box_at(settings_.size, level, levels_); }

int LocalLevels::Below::patch(int axis, int number) const {
  const LocalLine& l = lines[static_cast<std::size_t>(axis)];
  if (whole) return wrapped(number, patches_around(l.period));
  return (l.closed ? wrapped(number, patches_around(l.period)) : number) - l.first;
}

int LocalLevels::Below::slice(int axis, int voxel) const {
  const LocalLine& l = lines[static_cast<std::size_t>(axis)];
  if (whole) return wrapped(voxel, l.period);
  return (l.closed ? wrapped(voxel, l.period) : voxel) - l.from;
}

LocalLevels::Below LocalLevels::below(int level, const LocalBox& part, const LocalBox* core,
                                      const Work& work) const {
  Below out;
  out.whole = level - 1 == whole_.level;
  if (out.whole) {
    LocalBox all;
    all.hi = size(level - 1), all.closed = {true, true, true};
    out.lines = local_lines(all, all.hi);
    return out;
  }
  LocalBox needed = box_below(part, size(level), size(level - 1));
  if (core)
    for (int a = 0; a < 3; ++a) {  // it begins at 0
      needed.lo[a] = std::min(needed.lo[a], 0);
      needed.hi[a] = std::max(needed.hi[a], core->hi[a]);
    }
  const LevelStatistics& s = statistics_[static_cast<std::size_t>(level) - 1];
  out.made = run(level - 1, needed, core ? Upto::Blend : Upto::Matches, s, nullptr, nullptr, nullptr, work);
  out.lines = out.made.lines;
  return out;
}

void LocalLevels::carry(int level, const Below& below, LocalRegion& region, const Work& work) const {
  const Vec3i from = size(level - 1);
  std::array<CarriedPatches, 3> patches;
  std::array<std::vector<std::array<int, 2>>, 3> slices;
  std::array<std::vector<int>, 3> number;
  for (int a = 0; a < 3; ++a) {
    const auto k = static_cast<std::size_t>(a);
    const LocalLine& l = region.lines[k];
    CarriedPatches& c = patches[k];
    c.around = patches_around(l.period);
    c.miss.resize(l.start.size());
    for (int i = 0; i < l.patches(); ++i) {
      // On a closed axis copies come from where their originals do.
      const int q = l.closed ? wrapped(l.first + i, c.around) : l.first + i;
      c.number.push_back(wrapped(q, c.around));
      c.from.push_back(below.patch(
          a, patch_below(patch_start(q, l.period), l.period, from[a], c.miss[static_cast<std::size_t>(i)])));
    }
    for (int v = l.from; v < l.to; ++v) {
      const int voxel = l.closed ? wrapped(v, l.period) : v;
      slices[k].push_back(slices_below(voxel, l.period, from[a]));
      for (int& s : slices[k].back()) s = below.slice(a, s);
      number[k].push_back(wrapped(voxel, l.period));
    }
  }
  const auto& families = below.whole ? whole_.families : below.made.families;
  for (const MatchFamily& old : families) {
    const auto axis = static_cast<std::size_t>(old.axis);
    const Pyramid& p = pyramids_[static_cast<std::size_t>(old.exemplar)];
    region.families.push_back(local_family(region.lines, old.axis, old.exemplar));
    carry_matches(old, patches[static_cast<std::size_t>(kSliceColumns[axis])],
                  patches[static_cast<std::size_t>(kSliceRows[axis])], slices[axis], number[axis],
                  p[static_cast<std::size_t>(level) - 1], p[static_cast<std::size_t>(level)], settings_.seed,
                  region.families.back(), work);
  }
}

LocalLevels::Targets LocalLevels::targets_in(int level, const LocalBox& core, const Below& below) const {
  const auto wanted = level_values(level_of(pyramids_, level), settings_, channels_),
             coarse = level_values(level_of(pyramids_, level - 1), settings_, channels_);
  LocalBox box;
  const Vec3i from = size(level - 1);
  for (int a = 0; a < 3; ++a) box.hi[a] = core.hi[a] * from[a] / size(level)[a];
  const bool everywhere = core.closed == std::array{true, true, true};
  Targets out;
  for (int c = 0; c < channels_; ++c) {
    const auto k = static_cast<std::size_t>(c);
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

LocalRegion LocalLevels::run(int level, const LocalBox& wanted, Upto upto, const LevelStatistics& fixed,
                             LevelStatistics* measured, const LocalBox* core, BlendSources* sources,
                             const Work& work) const {
  const int rounds = iterations_[static_cast<std::size_t>(level)];
  const int finish = upto == Upto::Finish ? settings_.finish : 0;
  const LocalPlan plan = local_plan(wanted, rounds, finish);
  LocalRegion region;
  region.lines = local_lines(plan.blend[0], size(level));
  Targets targets;
  {
    const Below source = below(level, plan.blend[0], core, work.part(0, 0.3));
    carry(level, source, region, work.quiet());
    if (core) targets = targets_in(level, *core, source);
  }
  const Work own = work.part(0.3, 1);
  const auto exemplars = level_of(pyramids_, level);
  for (int a = 0; a < 3; ++a)
    region.field.size[a] = region.lines[static_cast<std::size_t>(a)].to - region.lines[static_cast<std::size_t>(a)].from;
  region.field.channel.assign(static_cast<std::size_t>(channels_),
                              std::vector<float>(static_cast<std::size_t>(region.field.size.cast<double>().prod())));
  const LevelStatistics& known = measured ? *measured : fixed;
  const int before = std::accumulate(iterations_.begin(), iterations_.begin() + level, 0);
  const bool to_blend = upto != Upto::Matches;
  // Statistics are measured, and sources kept, on the processor.
  int done = 0;
  if (gl_ && !core) {
    std::vector<float> windows;
    for (int i = -1; i < rounds; ++i) windows.push_back(window_at(i, rounds));
    const LocalPasses passes{exemplars, known, plan, windows, settings_.seed, before, (settings_.exponent - 2) / 2};
    gl_->run(passes, to_blend && !sources, region, own.part(0, 0.8));
    done = rounds;
  }

  const WeightTable weights((settings_.exponent - 2) / 2);

  const auto blend = [&](int i, float window, BlendSources* into, const Work& step) {
    const LocalBox& box = plan.blend[static_cast<std::size_t>(i)];
    BlendRange range;
    for (int a = 0; a < 3; ++a) {
      const LocalLine& l = region.lines[static_cast<std::size_t>(a)];
      range.covers[static_cast<std::size_t>(a)] = &l.cover;
      range.lo[a] = box.lo[a] - l.from, range.hi[a] = box.hi[a] - l.from;
    }
    std::vector<const std::vector<Vec3f>*> features;
    if (into) {
      into->texel.resize(region.field.channel[0].size()), into->exemplar.resize(region.field.channel[0].size());
      bool any = false;
      for (const auto& e : working_) features.push_back(&e.features), any |= !e.features.empty();
      if (any) into->features.assign(region.field.channel[0].size(), Vec3f::Zero());
    }
    blend_patches(exemplars, region.families, {window}, range, region.field, into, &features, step);
    if (core) {
      measured->values.emplace_back();
      for (int c = 0; c < channels_; ++c)
        measured->values.back().emplace_back(values_in(*core, region, c), targets.values[static_cast<std::size_t>(c)]);
    }
    for (std::size_t c = 0; c < region.field.channel.size(); ++c) {
      auto& v = region.field.channel[c];
      work.quiet().parallel(v.size(), 1 << 16, [&](std::size_t b, std::size_t e) {
        known.values[static_cast<std::size_t>(i)][c].apply(v.data() + b, e - b);
      });
      copy_beyond(region.lines, v, work.quiet());
    }
  };

  if (done == 0) blend(0, window_at(-1, rounds), nullptr, own.part(0, 0.1));
  for (int i = done; i < rounds; ++i) {
    const Work step = own.part(0.1 + 0.7 * i / rounds, 0.1 + 0.7 * (i + 1) / rounds);
    const LocalBox& box = plan.blend[static_cast<std::size_t>(i) + 1];
    search_locally(exemplars, known.penalty, box, settings_.seed, before + i, region, step.part(0, 0.6));
    if (core) {
      measured->floor.emplace_back();
      for (const MatchFamily& f : region.families) {
        double sum = 0, n = 0;
        each_patch(region.lines, f, *core, [&](std::size_t p) { sum += f.weight[p], ++n; });
        measured->floor.back().push_back(static_cast<float>(std::max(sum / n, 1e-12)));
      }
    }
    for (std::size_t k = 0; k < region.families.size(); ++k) {
      weigh_box(region.lines, box, weights, known.floor[static_cast<std::size_t>(i)][k], region.families[k],
                work.quiet());
      copy_beyond(region.lines, region.families[k], work.quiet());
    }
    const bool last = i + 1 == rounds;
    if (last && !to_blend) break;
    blend(i + 1, window_at(i, rounds), last ? sources : nullptr, step.part(0.6, 1));
  }
  if (done > 0 && sources) blend(rounds, window_at(rounds - 1, rounds), sources, work.quiet());
  if (finish == 0) return region;
  if (core) measured->finish.resize(static_cast<std::size_t>(channels_));
  for (int c = 0; c < channels_; ++c)
    for (int r = 0; r < finish; ++r) {
      FinishMaps maps =
          core ? FinishMaps{} : known.finish[static_cast<std::size_t>(c)][static_cast<std::size_t>(r)];
      finish_round(bands_, core ? targets.finished[static_cast<std::size_t>(c)] : Quantiles{}, c,
                   plan.finish[static_cast<std::size_t>(r)], core, maps, region, work.quiet());
      if (core) measured->finish[static_cast<std::size_t>(c)].push_back(std::move(maps));
      own.progress(0.8 + 0.2 * (c * finish + r + 1) / (channels_ * finish));
    }
  return region;
}

void LocalLevels::measure(const Work& work) {
  // How often each exemplar patch is in use in the whole level, for all levels above.
  std::vector<std::vector<float>> coarse;
  const auto at_whole = level_of(pyramids_, whole_.level);
  for (std::size_t e = 0; e < pyramids_.size(); ++e) {
    std::vector<double> count(at_whole[e]->usable.size(), 0);
    double all = 0;
    for (const auto& f : whole_.families)
      if (f.exemplar == static_cast<int>(e))
        for (const auto at : f.at) ++count[at], ++all;
    const double mean = std::max(all / static_cast<double>(at_whole[e]->starts.size()), 1e-9);
    coarse.emplace_back();
    for (const double n : count)
      coarse.back().push_back(
          static_cast<float>(1 + settings_.overuse * std::max(0.0, n / mean - 1)));
  }
  for (int level = whole_.level + 1; level < levels_; ++level) {
    LevelStatistics& s = statistics_[static_cast<std::size_t>(level)];
    for (std::size_t e = 0; e < pyramids_.size(); ++e) {
      const ExemplarLevel &from = *at_whole[e], &to = pyramids_[e][static_cast<std::size_t>(level)];
      s.penalty.emplace_back(to.usable.size(), 1.0f);
      const auto place = [](int start, int width, int coarse_width) {
        const double p = (start + kPatch / 2.0) * coarse_width / width - kPatch / 2.0;
        return std::clamp(static_cast<int>(std::floor(p + 0.5)), 0, coarse_width - kPatch);
      };
      for (const auto start : to.starts) {
        const int x = place(static_cast<int>(start) % to.width, to.width, from.width),
                  y = place(static_cast<int>(start) / to.width, to.height, from.height);
        s.penalty.back()[start] = coarse[e][static_cast<std::size_t>(y * from.width + x)];
      }
    }
    const LocalBox core = probe_box(size(level), settings_.local_limits);
    const double n = levels_ - 1 - whole_.level;
    run(level, core, level + 1 == levels_ ? Upto::Finish : Upto::Blend, s, &s, &core, nullptr,
        work.part((level - whole_.level - 1) / n, (level - whole_.level) / n));
  }
  whole_.field = {};
}

LocalRegion LocalLevels::make(const LocalBox& box, BlendSources* sources, const Work& work) const {
  return run(levels_ - 1, box, Upto::Finish, statistics_.back(), nullptr, nullptr, sources, work);
}

}  // namespace terrazzo::solid_optimize
