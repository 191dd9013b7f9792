#include "nodes/solids/synthesis/matching/blend.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/solids/synthesis/exemplar/wide.h"
#include "nodes/solids/synthesis/matching/cover.h"

namespace terrazzo::solids {
namespace {

// Texels weigh less towards a patch's edge (a Gaussian of 1.5 texels). Otherwise the grid of patch starts
// would show as blocks of two voxels.
constexpr std::array<float, kPatch> kInner = {0.0657285f, 0.2493522f, 0.6065307f, 0.9459595f,
                                              0.9459595f, 0.6065307f, 0.2493522f, 0.0657285f};

struct RowTask {
  const std::vector<const ExemplarLevel*>& exemplars;
  const std::vector<NeighborField>& families;
  const BlendRange& range;
  SolidField& field;
  float window;
  BlendSources* sources;
  const std::vector<const std::vector<Vec3f>*>* features;
  int y, z;
};

// The texels that the patches over two voxels contribute, in groups of eight: four for the first voxel, four
// for the second. Groups are padded with weight 0 where one voxel has fewer, and after a family's last texel.
template <int C>
struct Samples {
  int groups = 0;
  alignas(32) float value[C][2 * kMostCovering], weight[2 * kMostCovering];
  std::uint32_t texel[2 * kMostCovering];
  std::uint8_t from[2 * kMostCovering];
};

TERRAZZO_INLINE Eight load8(const float* p) { return *reinterpret_cast<const Eight*>(p); }
TERRAZZO_INLINE void store8(float* p, const Eight& v) { *reinterpret_cast<Eight*>(p) = v; }

// The patches of one family over two voxels that are neighbors along x.
struct PairCover {
  const PatchCover &c0, &c1;   // columns of patches over each voxel
  const PatchCover& cv;        // rows of patches over both
  std::size_t slice0, slice1;  // row 0 of each voxel's slice
  bool along;                  // x runs along the family's columns, so both are in one slice
};

// x runs along a family's columns or across its slices, never along its rows.
TERRAZZO_INLINE PairCover pair_cover(const RowTask& t, const NeighborField& f, const int (&x)[2]) {
  const std::size_t axis = f.axis;
  const auto& columns = *t.range.covers[kSliceColumns[axis]];
  const bool along = kSliceColumns[axis] == 0;
  const int v = kSliceRows[axis] == 2 ? t.z : t.y, across = f.axis == 1 ? t.y : t.z;
  return {columns[along ? x[0] : t.y],
          columns[along ? x[1] : t.y],
          (*t.range.covers[kSliceRows[axis]])[v],
          static_cast<std::size_t>(f.axis == 0 ? x[0] : across) * f.rows,
          static_cast<std::size_t>(f.axis == 0 ? x[1] : across) * f.rows,
          along};
}

// Stores the channels of a group, from four texels of each voxel.
template <int C>
TERRAZZO_INLINE void store_channels(const Eight& t0, const Eight& t1, const Eight& t2, const Eight& t3,
                                    int at, Samples<C>& s) {
  const Eight lo01 = __builtin_shufflevector(t0, t1, 0, 8, 1, 9, 4, 12, 5, 13),
              lo23 = __builtin_shufflevector(t2, t3, 0, 8, 1, 9, 4, 12, 5, 13);
  store8(s.value[0] + at, __builtin_shufflevector(lo01, lo23, 0, 1, 8, 9, 4, 5, 12, 13));
  if constexpr (C > 1)
    store8(s.value[1] + at, __builtin_shufflevector(lo01, lo23, 2, 3, 10, 11, 6, 7, 14, 15));
  if constexpr (C > 2) {
    const Eight hi01 = __builtin_shufflevector(t0, t1, 2, 10, 3, 11, 6, 14, 7, 15),
                hi23 = __builtin_shufflevector(t2, t3, 2, 10, 3, 11, 6, 14, 7, 15);
    store8(s.value[2] + at, __builtin_shufflevector(hi01, hi23, 0, 1, 8, 9, 4, 5, 12, 13));
    if constexpr (C > 3)
      store8(s.value[3] + at, __builtin_shufflevector(hi01, hi23, 2, 3, 10, 11, 6, 7, 14, 15));
  }
}

// Four patches per row over each voxel, which are processed together. Adds the weights to `total`.
template <int C>
TERRAZZO_INLINE void gather_even(const RowTask& t, const NeighborField& f, const PairCover& pair,
                                 Samples<C>& s, Eight& total) {
  const ExemplarLevel& e = *t.exemplars[f.exemplar];
  const PatchCover &c0 = pair.c0, &c1 = pair.c1, &cv = pair.cv;
  const FourInts in0 = *reinterpret_cast<const FourInts*>(c0.offset.data()),
                 in1 = *reinterpret_cast<const FourInts*>(c1.offset.data());
  Eight inner{};
  for (int k = 0; k < 4; ++k) {
    inner[k] = kInner[in0[k]];
    inner[4 + k] = kInner[in1[k]];
  }
  // The same patches cover both voxels: their texels are adjacent.
  const bool beside = pair.along && c0.patch[0] == c1.patch[0] && c0.offset[0] + 1 == c1.offset[0];
  for (int b = 0; b < cv.count; ++b, ++s.groups) {
    const std::size_t row = cv.patch[b];
    const std::size_t p0 = (pair.slice0 + row) * f.columns + c0.patch[0],
                      p1 = (pair.slice1 + row) * f.columns + c1.patch[0];
    const std::uint32_t down = cv.offset[b] * e.width;
    const FourInts s0 = *reinterpret_cast<const FourInts*>(&f.at[p0]) + in0 + down,
                   s1 = *reinterpret_cast<const FourInts*>(&f.at[p1]) + in1 + down;
    const Four w0 = *reinterpret_cast<const Four*>(&f.weight[p0]),
               w1 = *reinterpret_cast<const Four*>(&f.weight[p1]);
    const Eight w = __builtin_shufflevector(w0, w1, 0, 1, 2, 3, 4, 5, 6, 7) * inner * kInner[cv.offset[b]];
    const int at = 8 * s.groups;
    store8(s.weight + at, w);
    total += w;
    const auto load = [&](int k) __attribute__((always_inline)) {
      const float* first = &e.texels[4 * static_cast<std::size_t>(s0[k])];
      if (beside) return load8(first);
      return __builtin_shufflevector(
          *reinterpret_cast<const Four*>(first),
          *reinterpret_cast<const Four*>(&e.texels[4 * static_cast<std::size_t>(s1[k])]), 0, 1, 2, 3, 4, 5, 6,
          7);
    };
    store_channels<C>(load(0), load(1), load(2), load(3), at, s);
    if (t.sources)
      for (int k = 0; k < 4; ++k) {
        s.texel[at + k] = s0[k];
        s.texel[at + 4 + k] = s1[k];
      }
  }
}

// Any number of patches over each voxel. Adds the weights to `total`.
template <int C>
TERRAZZO_INLINE void gather_odd(const RowTask& t, const NeighborField& f, const PairCover& pair,
                                Samples<C>& s, Eight& total) {
  const ExemplarLevel& e = *t.exemplars[f.exemplar];
  const PatchCover& cv = pair.cv;
  const int begin = s.groups;
  s.groups += (cv.count * std::max(pair.c0.count, pair.c1.count) + 3) / 4;
  for (int k = 8 * begin; k < 8 * s.groups; ++k) {
    s.weight[k] = 0;
    for (int c = 0; c < C; ++c) s.value[c][k] = 0;
  }
  for (int h = 0; h < 2; ++h) {
    const PatchCover& cu = h == 0 ? pair.c0 : pair.c1;
    int n = 0;
    for (int b = 0; b < cv.count; ++b)
      for (int a = 0; a < cu.count; ++a, ++n) {
        const std::size_t i = a, j = b;
        const std::size_t row = (h == 0 ? pair.slice0 : pair.slice1) + cv.patch[j];
        const std::size_t patch = row * f.columns + cu.patch[i];
        const std::uint32_t source = f.at[patch] + (cv.offset[j] * e.width + cu.offset[i]);
        const int at = 8 * (begin + n / 4) + 4 * h + n % 4;
        for (int c = 0; c < C; ++c) s.value[c][at] = e.texels[4 * static_cast<std::size_t>(source) + c];
        s.weight[at] = f.weight[patch] * kInner[cu.offset[i]] * kInner[cv.offset[j]];
        s.texel[at] = source;
      }
  }
  for (int g = begin; g < s.groups; ++g) total += load8(s.weight + 8 * g);
}

// Collects the patches of one family over voxels (x0, y, z) and (x1, y, z).
template <int C>
TERRAZZO_INLINE void gather(const RowTask& t, const NeighborField& f, const int (&x)[2], Samples<C>& s) {
  const PairCover pair = pair_cover(t, f, x);
  const int begin = s.groups;
  Eight total{};
  if (pair.c0.even && pair.c1.even)
    gather_even<C>(t, f, pair, s, total);
  else
    gather_odd<C>(t, f, pair, s, total);
  const Eight equal = 1.0f / half_sums(total);
  for (int g = begin; g < s.groups; ++g) store8(s.weight + 8 * g, load8(s.weight + 8 * g) * equal);
  if (t.sources) std::fill(s.from + 8 * begin, s.from + 8 * s.groups, static_cast<std::uint8_t>(f.exemplar));
}

// The weighted mean and the spread around it.
template <int C>
TERRAZZO_INLINE void weighted_mean(const Samples<C>& s, Eight (&mean)[C], Eight& spread) {
  Eight w_sum{}, sum[C] = {}, squares{};
  for (int k = 0; k < 8 * s.groups; k += 8) {
    const Eight w = load8(s.weight + k);
    w_sum += w;
#pragma GCC unroll 4
    for (int c = 0; c < C; ++c) {
      const Eight v = load8(s.value[c] + k);
      sum[c] += w * v;
      squares += w * v * v;
    }
  }
  const Eight all = 1.0f / half_sums(w_sum);
#pragma GCC unroll 4
  for (int c = 0; c < C; ++c) {
    mean[c] = half_sums(sum[c]) * all;
    spread -= mean[c] * mean[c];
  }
  spread += half_sums(squares) * all;
}

// Shifts the mean where samples spread. `narrow`: square of the last window.
template <int C>
TERRAZZO_INLINE void shift_mean(const Samples<C>& s, float narrow, const Eight& spread, Eight (&mean)[C]) {
  // Three steps: the squared window falls geometrically from the spread to its final size.
  Eight width{}, root{};
  const auto spreads = spread > 1e-12f;
  for (int h = 0; h < 8; h += 4) {
    const float from = spreads[h] ? spread[h] : 1, fall = std::min(1.0f, std::sqrt(narrow / from));
    for (int k = h; k < h + 4; ++k) {
      width[k] = from;
      root[k] = fall;
    }
  }
  Eight shifted[C];
#pragma GCC unroll 4
  for (int c = 0; c < C; ++c) shifted[c] = mean[c];
  for (int step = 0; step < 3; ++step) {
    const Eight inverse = 1.0f / width;
    Eight w_sum{}, sum[C] = {};
    for (int k = 0; k < 8 * s.groups; k += 8) {
      Eight far{}, v[C];
#pragma GCC unroll 4
      for (int c = 0; c < C; ++c) {
        v[c] = load8(s.value[c] + k);
        const Eight d = v[c] - shifted[c];
        far += d * d;
      }
      const Eight close = 1.0f + far * inverse;
      const Eight w = load8(s.weight + k) / (close * close);
      w_sum += w;
#pragma GCC unroll 4
      for (int c = 0; c < C; ++c) sum[c] += w * v[c];
    }
    const Eight norm = 1.0f / half_sums(w_sum);
#pragma GCC unroll 4
    for (int c = 0; c < C; ++c) shifted[c] = half_sums(sum[c]) * norm;
    width *= root;
    width = width > 1e-8f ? width : Eight{} + 1e-8f;
  }
#pragma GCC unroll 4
  for (int c = 0; c < C; ++c) mean[c] = spreads ? shifted[c] : mean[c];
}

// Stores the texel closest to the mean, by weight, as the source of voxel h of the pair.
template <int C>
TERRAZZO_INLINE void store_source(const RowTask& t, const Samples<C>& s, int h, float narrow,
                                  const Eight (&mean)[C], std::size_t voxel) {
  const float inverse = 1 / std::max(narrow, 1e-4f);
  int best = 4 * h;
  float most = 0;
  for (int i = 0; i < 4 * s.groups; ++i) {
    const int k = i / 4 * 8 + 4 * h + i % 4;
    float far = 0;
    for (int c = 0; c < C; ++c) far += (s.value[c][k] - mean[c][4 * h]) * (s.value[c][k] - mean[c][4 * h]);
    const float w = s.weight[k] / ((1 + far * inverse) * (1 + far * inverse));
    if (w > most) {
      most = w;
      best = k;
    }
  }
  t.sources->texel[voxel] = s.texel[best];
  t.sources->exemplar[voxel] = s.from[best];
  if (t.features && !t.sources->features.empty()) {
    const auto* carried = (*t.features)[s.from[best]];
    if (carried && !carried->empty()) t.sources->features[voxel] = (*carried)[s.texel[best]];
  }
}

template <int C>
TERRAZZO_INLINE void blend_body(const RowTask& t) {
  const Vec3i& size = t.field.size;
  const float narrow = std::max(t.window * t.window, 1e-8f);
  const std::size_t first =
      (static_cast<std::size_t>(t.z) * static_cast<std::size_t>(size.y()) + static_cast<std::size_t>(t.y)) *
      size.x();
  Samples<C> s;
  for (int x0 = t.range.lo.x(); x0 < t.range.hi.x(); x0 += 2) {
    const int x[2] = {x0, std::min(x0 + 1, t.range.hi.x() - 1)};
    s.groups = 0;
    for (const NeighborField& f : t.families) gather<C>(t, f, x, s);
    Eight mean[C], spread{};
    weighted_mean<C>(s, mean, spread);
    if (t.window > 0) shift_mean<C>(s, narrow, spread, mean);
    for (int h = 0; h < 2; ++h) {
      const std::size_t voxel = first + x[h];
      for (int c = 0; c < C; ++c) t.field.channel[c][voxel] = mean[c][4 * h];
      if (t.sources) store_source<C>(t, s, h, narrow, mean, voxel);
    }
  }
}

template <int C>
TERRAZZO_AVX2 void blend_avx2(const RowTask& t) {
  blend_body<C>(t);
}
template <int C>
void blend_plain(const RowTask& t) {
  blend_body<C>(t);
}

}  // namespace

void blend_patches(const std::vector<const ExemplarLevel*>& exemplars,
                   const std::vector<NeighborField>& families, const BlendOptions& settings,
                   SolidField& field, BlendSources* sources,
                   const std::vector<const std::vector<Vec3f>*>* features, const Work& work) {
  const std::array<std::vector<PatchCover>, 3> cover = {
      patch_covers(field.size.x()), patch_covers(field.size.y()), patch_covers(field.size.z())};
  blend_patches(exemplars, families, settings, {{&cover[0], &cover[1], &cover[2]}, Vec3i::Zero(), field.size},
                field, sources, features, work);
}

void blend_patches(const std::vector<const ExemplarLevel*>& exemplars,
                   const std::vector<NeighborField>& families, const BlendOptions& settings,
                   const BlendRange& range, SolidField& field, BlendSources* sources,
                   const std::vector<const std::vector<Vec3f>*>* features, const Work& work) {
  static const bool avx2 = has_avx2();
  using Row = void (*)(const RowTask&);
  static const Row rows[2][4] = {{blend_plain<1>, blend_plain<2>, blend_plain<3>, blend_plain<4>},
                                 {blend_avx2<1>, blend_avx2<2>, blend_avx2<3>, blend_avx2<4>}};
  const Row row = rows[avx2][field.channel.size() - 1];
  // Squares of 8 × 8 rows share their patches in the cache.
  const int by = (range.hi.y() - range.lo.y() + 7) / 8, bz = (range.hi.z() - range.lo.z() + 7) / 8;
  work.parallel(static_cast<std::size_t>(by) * bz, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int y0 = range.lo.y() + 8 * static_cast<int>(i % by),
                z0 = range.lo.z() + 8 * static_cast<int>(i / by);
      for (int z = z0; z < std::min(z0 + 8, range.hi.z()); ++z)
        for (int y = y0; y < std::min(y0 + 8, range.hi.y()); ++y)
          row({exemplars, families, range, field, settings.window, sources, features, y, z});
    }
  });
}

}  // namespace terrazzo::solids
