#include "nodes/solids/synthesis/matching/search.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/matching/candidates.h"
#include "runtime/random.h"

namespace terrazzo::solids {
namespace {

// Counts how often each exemplar patch is used. Each phase of a search reads the counts of earlier phases.
class Usage {
 public:
  Usage(const ExemplarLevel& e, double mean)
      : count_(e.usable.size()), penalty_(e.usable.size(), 1.0f), mean_(std::max(mean, 1e-9)) {}
  void move(std::uint32_t from, std::uint32_t to) {
    count_[from].fetch_sub(1, std::memory_order_relaxed);
    count_[to].fetch_add(1, std::memory_order_relaxed);
  }
  void add(std::uint32_t at) { count_[at].fetch_add(1, std::memory_order_relaxed); }
  void publish(float overuse, const std::vector<std::uint32_t>& starts) {
    for (const auto s : starts)
      penalty_[s] = 1 + overuse * std::max<float>(0.0f, count_[s].load() / mean_ - 1);
  }
  const float* penalty() const { return penalty_.data(); }

 private:
  std::vector<std::atomic<std::int32_t>> count_;
  std::vector<float> penalty_;
  double mean_;
};

struct SliceTask {
  const ExemplarLevel& e;
  NeighborField& f;
  const float* penalty;
  Usage& usage;
  const SearchOptions& settings;
  int slice;
  const float* picture;  // from read_slice
  float* features;       // features of one row of patches
};

TERRAZZO_INLINE void search_body(const SliceTask& t) {
  const ExemplarLevel& e = t.e;
  NeighborField& f = t.f;
  const int dims = e.space.dims;
  const std::size_t pitch = static_cast<std::size_t>(f.width + kPatch - 1) * e.channels;
  const std::size_t plane = pixels_in(f.columns, f.rows);
  std::uint32_t* at = &f.at[t.slice * plane];
  const std::uint32_t* below = &f.at[((t.slice + f.slices - 1) % f.slices) * plane];
  const std::uint32_t* above = &f.at[((t.slice + 1) % f.slices) * plane];
  float* weight = &f.weight[t.slice * plane];
  const Penalties penalties(t.penalty, t.settings.copying);
  const bool forwards = t.settings.iteration % 2 == 0;
  // Each sweep starts somewhere else. A sweep makes matches coherent along its path, but they do not fit
  // where it ends; that must not always be the wrap.
  Random origin(t.settings.seed, 0x4000 + static_cast<std::uint64_t>(t.settings.iteration) * 3 + f.axis,
                static_cast<std::uint64_t>(t.slice));
  const int first_i = origin.below(static_cast<std::uint64_t>(f.columns)),
            first_j = origin.below(static_cast<std::uint64_t>(f.rows));

  for (int jj = 0; jj < f.rows; ++jj) {
    const int j = (first_j + (forwards ? jj : f.rows - 1 - jj)) % f.rows;
    project(e.space, t.picture + (2 * j) * pitch, pitch, 2, f.columns, t.features);
    for (int ii = 0; ii < f.columns; ++ii) {
      const int i = (first_i + (forwards ? ii : f.columns - 1 - ii)) % f.columns;
      const std::size_t n = pixel_at(i, j, f.columns);
      const float* query = t.features + static_cast<std::ptrdiff_t>(i) * dims;
      const std::size_t row = static_cast<std::size_t>(j) * f.columns;
      const std::size_t left = row + (i > 0 ? i - 1 : f.columns - 1),
                        right = row + (i + 1 < f.columns ? i + 1 : 0);
      const std::size_t down = static_cast<std::size_t>(j > 0 ? j - 1 : f.rows - 1) * f.columns + i,
                        up = static_cast<std::size_t>(j + 1 < f.rows ? j + 1 : 0) * f.columns + i;
      // Across the wrap of an odd width the step is 1, not 2.
      const int from_left = i > 0 || f.width % 2 == 0 ? 2 : 1,
                from_right = i + 1 < f.columns || f.width % 2 == 0 ? -2 : -1,
                from_down = j > 0 || f.height % 2 == 0 ? 2 : 1,
                from_up = j + 1 < f.rows || f.height % 2 == 0 ? -2 : -1;
      const FourInts goes_on = {at[left] + from_left, at[right] + from_right,
                                at[down] + (from_down * e.width), at[up] + (from_up * e.width)};
      Best best(e, query, penalties, goes_on, at[n]);
      if (t.settings.exhaustive) {
        for (const auto c : e.starts) best.consider(c);
      } else {
        best.shifted(at[left], from_left, 0);
        best.shifted(at[right], from_right, 0);
        best.shifted(at[down], 0, from_down);
        best.shifted(at[up], 0, from_up);
        best.consider(below[n]);
        best.consider(above[n]);
        best.similar();
        Random random(t.settings.seed, 0x1000 + static_cast<std::uint64_t>(t.settings.iteration) * 3 + f.axis,
                      t.slice * plane + n);
        best.around(32, [&] {
          const std::uint64_t bits = random.bits();
          return std::array<std::uint64_t, 2>{bits & 0xffffffffu, bits >> 32};
        });
      }
      weight[n] = best.distance;
      if (best.at != at[n]) {
        t.usage.move(at[n], best.at);
        at[n] = best.at;
      }
    }
  }
}
TERRAZZO_AVX2 void search_avx2(const SliceTask& t) { search_body(t); }
void search_plain(const SliceTask& t) { search_body(t); }

}  // namespace

void read_slice(const SolidField& field, int axis, int slice, std::vector<float>& out) {
  const int u = kSliceColumns[axis], v = kSliceRows[axis];
  const int width = field.size[u], height = field.size[v];
  const std::size_t step[3] = {1, static_cast<std::size_t>(field.size.x()),
                               pixels_in(field.size.x(), field.size.y())};
  const std::size_t channels = field.channel.size();
  const int w = width + kPatch - 1, h = height + kPatch - 1;
  out.resize(pixels_in(w, h) * channels);
  // Across x each voxel is in a cache line of its own.
  const std::size_t ahead = u == 0 ? 0 : 2 * step[v];
  for (std::size_t c = 0; c < channels; ++c) {
    const float* from = field.channel[c].data() + slice * step[axis];
    for (int y = 0; y < h; ++y) {
      const float* row = from + (y % height) * step[v];
      float* to = &out[static_cast<std::size_t>(y) * w * channels + c];
      // Only the first few columns repeat.
      for (int x = 0; x < width; ++x) {
        if (ahead) __builtin_prefetch(row + x * step[u] + ahead);
        to[x * channels] = row[x * step[u]];
      }
      for (int x = width; x < w; ++x) to[x * channels] = to[(x - width) * channels];
    }
  }
}

void search_matches(const SolidField& field, const std::vector<const ExemplarLevel*>& exemplars,
                    std::vector<NeighborField>& families, const SearchOptions& settings, const Work& work) {
  static const bool avx2 = has_avx2();
  std::vector<Usage> usage;
  usage.reserve(exemplars.size());
  for (std::size_t e = 0; e < exemplars.size(); ++e) {
    double matches = 0;
    for (const auto& f : families)
      if (f.exemplar == static_cast<int>(e)) matches += f.count();
    usage.emplace_back(*exemplars[e], matches / exemplars[e]->starts.size());
    for (const auto& f : families)
      if (f.exemplar == static_cast<int>(e))
        for (const auto at : f.at) usage[e].add(at);
  }
  // Slices of one phase are never neighbors, so the slices that a slice reads are settled.
  constexpr int kPhases = 8;
  struct Item {
    int family, slice;
  };
  std::vector<std::vector<Item>> parts(kPhases + 1);
  for (int k = 0; k < count_of(families); ++k)
    for (int s = 0; s < families[k].slices; ++s) {
      const bool meets_first = s > 0 && s == families[k].slices - 1 && s % kPhases == 0;
      parts[meets_first ? kPhases : s % kPhases].push_back({k, s});
    }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t e = 0; e < exemplars.size(); ++e)
      usage[e].publish(settings.overuse, exemplars[e]->starts);
    work.quiet().parallel(parts[p].size(), 1, [&](std::size_t begin, std::size_t end) {
      std::vector<float> picture, features;
      for (std::size_t i = begin; i < end; ++i) {
        NeighborField& f = families[parts[p][i].family];
        const ExemplarLevel& e = *exemplars[f.exemplar];
        read_slice(field, f.axis, parts[p][i].slice, picture);
        features.resize(static_cast<std::size_t>(f.columns) * e.space.dims);
        Usage& u = usage[f.exemplar];
        const SliceTask task{
            e, f, u.penalty(), u, settings, parts[p][i].slice, picture.data(), features.data()};
        avx2 ? search_avx2(task) : search_plain(task);
      }
    });
    work.done(p + 1, parts.size());
  }
}

}  // namespace terrazzo::solids
