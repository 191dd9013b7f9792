#include "nodes/solid_optimize/search.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "nodes/solid_optimize/wide.h"
#include "runtime/random.h"

namespace terrazzo::solid_optimize {
namespace {

// How often each exemplar patch is in use. Phases of a search read what earlier phases left.
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
      penalty_[s] = 1 + overuse * std::max(0.0f, static_cast<float>(count_[s].load() / mean_ - 1));
  }
  const float* penalty() const { return penalty_.data(); }

 private:
  std::vector<std::atomic<std::int32_t>> count_;
  std::vector<float> penalty_;
  double mean_;
};

struct SliceTask {
  const ExemplarLevel& e;
  MatchFamily& f;
  const float* penalty;
  Usage& usage;
  const SearchSettings& settings;
  int slice;
  const float* picture;  // read_slice
  float* features;       // of one row of patches
};

// Squared distance of two points; anything above `limit` where it exceeds that.
TERRAZZO_INLINE float distance2(const float* a, const float* b, int dims, float limit) {
  Eight d = *reinterpret_cast<const Eight*>(a) - *reinterpret_cast<const Eight*>(b);
  Eight sum = d * d;
  d = *reinterpret_cast<const Eight*>(a + 8) - *reinterpret_cast<const Eight*>(b + 8);
  sum += d * d;
  if (dims > 16) {
    const float part = sum_of(sum);
    if (part > limit) return part;
    for (int k = 16; k < dims; k += 8) {
      d = *reinterpret_cast<const Eight*>(a + k) - *reinterpret_cast<const Eight*>(b + k);
      sum += d * d;
    }
  }
  return sum_of(sum);
}

TERRAZZO_INLINE void search_body(const SliceTask& t) {
  const ExemplarLevel& e = t.e;
  MatchFamily& f = t.f;
  const int dims = e.space.dims, w = e.width;
  const std::size_t pitch =
      static_cast<std::size_t>(f.width + kPatch - 1) * static_cast<std::size_t>(e.channels);
  const std::size_t plane = static_cast<std::size_t>(f.columns) * static_cast<std::size_t>(f.rows);
  std::uint32_t* at = &f.at[static_cast<std::size_t>(t.slice) * plane];
  const std::uint32_t* below = &f.at[static_cast<std::size_t>((t.slice + f.slices - 1) % f.slices) * plane];
  const std::uint32_t* above = &f.at[static_cast<std::size_t>((t.slice + 1) % f.slices) * plane];
  float* weight = &f.weight[static_cast<std::size_t>(t.slice) * plane];
  const int last_x = e.width - kPatch, last_y = e.height - kPatch;
  const bool forwards = t.settings.iteration % 2 == 0;
  // Each sweep starts somewhere else: what it makes coherent along its way does not fit where it ends, which
  // must not always be the wrap.
  Random origin(
      t.settings.seed,
      0x4000 + static_cast<std::uint64_t>(t.settings.iteration) * 3 + static_cast<std::uint64_t>(f.axis),
      static_cast<std::uint64_t>(t.slice));
  const int first_i = static_cast<int>(origin.below(static_cast<std::uint64_t>(f.columns))),
            first_j = static_cast<int>(origin.below(static_cast<std::uint64_t>(f.rows)));

  for (int jj = 0; jj < f.rows; ++jj) {
    const int j = (first_j + (forwards ? jj : f.rows - 1 - jj)) % f.rows;
    project(e.space, t.picture + static_cast<std::size_t>(2 * j) * pitch, pitch, 2, f.columns, t.features);
    for (int ii = 0; ii < f.columns; ++ii) {
      const int i = (first_i + (forwards ? ii : f.columns - 1 - ii)) % f.columns;
      const std::size_t n =
          static_cast<std::size_t>(j) * static_cast<std::size_t>(f.columns) + static_cast<std::size_t>(i);
      const float* query = t.features + static_cast<std::ptrdiff_t>(i) * dims;
      std::uint32_t best = at[n];
      float best_distance = distance2(query, e.feature(best), dims, std::numeric_limits<float>::infinity());
      float best_score = best_distance * t.penalty[best];
      const auto consider = [&](std::uint32_t c) __attribute__((always_inline)) {
        if (c == best) return;
        const float p = t.penalty[c];
        const float d = distance2(query, e.feature(c), dims, best_score / p);
        const float s = d * p;
        if (s < best_score) best = c, best_score = s, best_distance = d;
      };
      if (t.settings.exhaustive) {
        for (const auto c : e.starts) consider(c);
      } else {
        const auto shifted = [&](std::uint32_t c, int dx, int dy) __attribute__((always_inline)) {
          const int x = static_cast<int>(c) % w + dx, y = static_cast<int>(c) / w + dy;
          if (x < 0 || y < 0 || x > last_x || y > last_y) return;
          const auto s = static_cast<std::uint32_t>(y * w + x);
          if (e.usable[s]) consider(s);
        };
        const std::size_t row = static_cast<std::size_t>(j) * static_cast<std::size_t>(f.columns);
        const std::size_t left = row + static_cast<std::size_t>(i > 0 ? i - 1 : f.columns - 1),
                          right = row + static_cast<std::size_t>(i + 1 < f.columns ? i + 1 : 0);
        const std::size_t down = static_cast<std::size_t>(j > 0 ? j - 1 : f.rows - 1) * f.columns + i,
                          up = static_cast<std::size_t>(j + 1 < f.rows ? j + 1 : 0) * f.columns + i;
        // Across the wrap of an odd width the step is 1, not 2.
        shifted(at[left], i > 0 || f.width % 2 == 0 ? 2 : 1, 0);
        shifted(at[right], i + 1 < f.columns || f.width % 2 == 0 ? -2 : -1, 0);
        shifted(at[down], 0, j > 0 || f.height % 2 == 0 ? 2 : 1);
        shifted(at[up], 0, j + 1 < f.rows || f.height % 2 == 0 ? -2 : -1);
        consider(below[n]);
        consider(above[n]);
        const std::uint32_t* similar = &e.similar[static_cast<std::size_t>(best) * ExemplarLevel::kSimilar];
        for (int k = 0; k < ExemplarLevel::kSimilar; ++k) consider(similar[k]);
        Random random(t.settings.seed,
                      0x1000 + static_cast<std::uint64_t>(t.settings.iteration) * 3 +
                          static_cast<std::uint64_t>(f.axis),
                      static_cast<std::uint64_t>(t.slice) * plane + n);
        for (int reach = std::max(last_x, last_y); reach >= 2; reach = reach * 2 / 5) {
          const std::uint64_t bits = random.bits();
          const int x0 = static_cast<int>(best) % w, y0 = static_cast<int>(best) / w;
          const int lo_x = std::max(0, x0 - reach), lo_y = std::max(0, y0 - reach);
          const int hi_x = std::min(last_x, x0 + reach), hi_y = std::min(last_y, y0 + reach);
          const int x =
              lo_x +
              static_cast<int>(((bits & 0xffffffffu) * static_cast<std::uint64_t>(hi_x - lo_x + 1)) >> 32);
          const int y =
              lo_y + static_cast<int>(((bits >> 32) * static_cast<std::uint64_t>(hi_y - lo_y + 1)) >> 32);
          const auto c = static_cast<std::uint32_t>(y * w + x);
          if (e.usable[c]) consider(c);
        }
      }
      weight[n] = best_distance;
      if (best != at[n]) {
        t.usage.move(at[n], best);
        at[n] = best;
      }
    }
  }
}
TERRAZZO_AVX2 void search_avx2(const SliceTask& t) { search_body(t); }
void search_plain(const SliceTask& t) { search_body(t); }

}  // namespace

void read_slice(const SolidField& field, int axis, int slice, std::vector<float>& out) {
  const int u = kSliceColumns[static_cast<std::size_t>(axis)], v = kSliceRows[static_cast<std::size_t>(axis)];
  const int width = field.size[u], height = field.size[v];
  const std::size_t step[3] = {
      1, static_cast<std::size_t>(field.size.x()),
      static_cast<std::size_t>(field.size.x()) * static_cast<std::size_t>(field.size.y())};
  const std::size_t channels = field.channel.size();
  const int w = width + kPatch - 1, h = height + kPatch - 1;
  out.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * channels);
  for (std::size_t c = 0; c < channels; ++c) {
    const float* from = field.channel[c].data() + static_cast<std::size_t>(slice) * step[axis];
    for (int y = 0; y < h; ++y) {
      const float* row = from + static_cast<std::size_t>(y % height) * step[v];
      float* to = &out[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) * channels + c];
      for (int x = 0; x < w; ++x)
        to[static_cast<std::size_t>(x) * channels] = row[static_cast<std::size_t>(x % width) * step[u]];
    }
  }
}

void search_matches(const SolidField& field, const std::vector<const ExemplarLevel*>& exemplars,
                    std::vector<MatchFamily>& families, const SearchSettings& settings, const Work& work) {
  static const bool avx2 = has_avx2();
  std::vector<Usage> usage;
  usage.reserve(exemplars.size());
  for (std::size_t e = 0; e < exemplars.size(); ++e) {
    double matches = 0;
    for (const auto& f : families)
      if (f.exemplar == static_cast<int>(e)) matches += static_cast<double>(f.count());
    usage.emplace_back(*exemplars[e], matches / static_cast<double>(exemplars[e]->starts.size()));
    for (const auto& f : families)
      if (f.exemplar == static_cast<int>(e))
        for (const auto at : f.at) usage[e].add(at);
  }
  // Slices of one phase are never neighbours, so that a slice reads of the next ones what is settled.
  constexpr int phases = 8;
  struct Item {
    int family, slice;
  };
  std::vector<std::vector<Item>> parts(phases + 1);
  for (int k = 0; k < static_cast<int>(families.size()); ++k)
    for (int s = 0; s < families[static_cast<std::size_t>(k)].slices; ++s) {
      const bool meets_first =
          s > 0 && s == families[static_cast<std::size_t>(k)].slices - 1 && s % phases == 0;
      parts[static_cast<std::size_t>(meets_first ? phases : s % phases)].push_back({k, s});
    }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t e = 0; e < exemplars.size(); ++e)
      usage[e].publish(settings.overuse, exemplars[e]->starts);
    work.quiet().parallel(parts[p].size(), 1, [&](std::size_t begin, std::size_t end) {
      std::vector<float> picture, features;
      for (std::size_t i = begin; i < end; ++i) {
        MatchFamily& f = families[static_cast<std::size_t>(parts[p][i].family)];
        const ExemplarLevel& e = *exemplars[static_cast<std::size_t>(f.exemplar)];
        read_slice(field, f.axis, parts[p][i].slice, picture);
        features.resize(static_cast<std::size_t>(f.columns) * static_cast<std::size_t>(e.space.dims));
        Usage& u = usage[static_cast<std::size_t>(f.exemplar)];
        const SliceTask task{
            e, f, u.penalty(), u, settings, parts[p][i].slice, picture.data(), features.data()};
        avx2 ? search_avx2(task) : search_plain(task);
      }
    });
    work.progress(static_cast<double>(p + 1) / static_cast<double>(parts.size()));
  }
}

}  // namespace terrazzo::solid_optimize
