#include "nodes/solid_optimize/blend.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/solid_optimize/cover.h"
#include "nodes/solid_optimize/wide.h"

namespace terrazzo::solid_optimize {
namespace {

// Texels count less towards a patch's edge (a Gaussian of 1.5 texels), or the grid on which patches start
// would show as blocks of two voxels.
constexpr std::array<float, kPatch> kInner = {0.0657285f, 0.2493522f, 0.6065307f, 0.9459595f,
                                              0.9459595f, 0.6065307f, 0.2493522f, 0.0657285f};

struct RowTask {
  const std::vector<const ExemplarLevel*>& exemplars;
  const std::vector<MatchFamily>& families;
  const BlendRange& range;
  SolidField& field;
  float window;
  BlendSources* sources;
  const std::vector<const std::vector<Vec3f>*>* features;
  int y, z;
};

template <int C>
TERRAZZO_INLINE void blend_body(const RowTask& t) {
  const Vec3i& size = t.field.size;
  alignas(32) float value[C][kMostCovering], weight[kMostCovering];
  std::uint32_t texel[kMostCovering];
  std::uint8_t from[kMostCovering];
  const float narrow = std::max(t.window * t.window, 1e-8f);
  for (int x = t.range.lo.x(); x < t.range.hi.x(); ++x) {
    const int at[3] = {x, t.y, t.z};
    int n = 0;
    for (const MatchFamily& f : t.families) {
      const ExemplarLevel& e = *t.exemplars[static_cast<std::size_t>(f.exemplar)];
      const PatchCover& cu = (*t.range.covers[static_cast<std::size_t>(kSliceColumns[static_cast<std::size_t>(
          f.axis)])])[static_cast<std::size_t>(at[kSliceColumns[static_cast<std::size_t>(f.axis)]])];
      const PatchCover& cv = (*t.range.covers[static_cast<std::size_t>(kSliceRows[static_cast<std::size_t>(
          f.axis)])])[static_cast<std::size_t>(at[kSliceRows[static_cast<std::size_t>(f.axis)]])];
      const int begin = n;
      float total = 0;
      for (int b = 0; b < cv.count; ++b) {
        const std::size_t row = (static_cast<std::size_t>(at[f.axis]) * static_cast<std::size_t>(f.rows) +
                                 static_cast<std::size_t>(cv.patch[static_cast<std::size_t>(b)])) *
                                static_cast<std::size_t>(f.columns);
        const auto down = static_cast<std::uint32_t>(cv.offset[static_cast<std::size_t>(b)] * e.width);
        const float inner = kInner[static_cast<std::size_t>(cv.offset[static_cast<std::size_t>(b)])];
        if (cu.even) {  // four patches in a row, at once
          const std::size_t patch = row + static_cast<std::size_t>(cu.patch[0]);
          const auto* at4 = reinterpret_cast<const FourInts*>(&f.at[patch]);
          const FourInts source = *at4 + *reinterpret_cast<const FourInts*>(cu.offset.data()) + down;
          const Four inner_u = {
              kInner[static_cast<std::size_t>(cu.offset[0])], kInner[static_cast<std::size_t>(cu.offset[1])],
              kInner[static_cast<std::size_t>(cu.offset[2])], kInner[static_cast<std::size_t>(cu.offset[3])]};
          const Four w = *reinterpret_cast<const Four*>(&f.weight[patch]) * inner_u * inner;
          *reinterpret_cast<Four*>(weight + n) = w;
          total += (w[0] + w[1]) + (w[2] + w[3]);
          const auto load = [&](int k) __attribute__((always_inline)) {
            return *reinterpret_cast<const Four*>(&e.texels[4 * static_cast<std::size_t>(source[k])]);
          };
          const Four t0 = load(0), t1 = load(1), t2 = load(2), t3 = load(3);
          const Four lo01 = __builtin_shufflevector(t0, t1, 0, 4, 1, 5),
                     lo23 = __builtin_shufflevector(t2, t3, 0, 4, 1, 5);
          *reinterpret_cast<Four*>(value[0] + n) = __builtin_shufflevector(lo01, lo23, 0, 1, 4, 5);
          if constexpr (C > 1)
            *reinterpret_cast<Four*>(value[1] + n) = __builtin_shufflevector(lo01, lo23, 2, 3, 6, 7);
          if constexpr (C > 2) {
            const Four hi01 = __builtin_shufflevector(t0, t1, 2, 6, 3, 7),
                       hi23 = __builtin_shufflevector(t2, t3, 2, 6, 3, 7);
            *reinterpret_cast<Four*>(value[2] + n) = __builtin_shufflevector(hi01, hi23, 0, 1, 4, 5);
            if constexpr (C > 3)
              *reinterpret_cast<Four*>(value[3] + n) = __builtin_shufflevector(hi01, hi23, 2, 3, 6, 7);
          }
          if (t.sources)
            for (int k = 0; k < 4; ++k)
              texel[n + k] = source[k], from[n + k] = static_cast<std::uint8_t>(f.exemplar);
          n += 4;
          continue;
        }
        for (int a = 0; a < cu.count; ++a, ++n) {
          const std::size_t patch = row + static_cast<std::size_t>(cu.patch[static_cast<std::size_t>(a)]);
          const std::uint32_t source =
              f.at[patch] + down + static_cast<std::uint32_t>(cu.offset[static_cast<std::size_t>(a)]);
          for (int c = 0; c < C; ++c)
            value[c][n] = e.texels[4 * static_cast<std::size_t>(source) + static_cast<std::size_t>(c)];
          weight[n] = f.weight[patch] *
                      kInner[static_cast<std::size_t>(cu.offset[static_cast<std::size_t>(a)])] * inner;
          total += weight[n];
          texel[n] = source, from[n] = static_cast<std::uint8_t>(f.exemplar);
        }
      }
      const float equal = 1 / total;
      for (int k = begin; k < n; ++k) weight[k] *= equal;
    }
    const int used = n;
    for (; n % 8 != 0; ++n) {
      weight[n] = 0;
      for (int c = 0; c < C; ++c) value[c][n] = 0;
    }
    // The weighted mean and the spread about it; then the mean shift.
    float mean[C], spread = 0, all;
    {
      Eight w_sum{}, sum[C] = {}, squares{};
      for (int k = 0; k < n; k += 8) {
        const Eight w = *reinterpret_cast<const Eight*>(weight + k);
        w_sum += w;
        for (int c = 0; c < C; ++c) {
          const Eight v = *reinterpret_cast<const Eight*>(value[c] + k);
          sum[c] += w * v, squares += w * v * v;
        }
      }
      all = 1 / sum_of(w_sum);
      for (int c = 0; c < C; ++c) mean[c] = sum_of(sum[c]) * all, spread -= mean[c] * mean[c];
      spread = std::max(0.0f, spread + sum_of(squares) * all);
    }
    if (t.window > 0 && spread > 1e-12f) {
      // Three steps, the squared window falling geometrically from the spread to its own size.
      const float root = std::min(1.0f, std::sqrt(narrow / spread));
      float width = spread;
      for (int step = 0; step < 3; ++step) {
        const float inverse = 1 / width;
        Eight w_sum{}, sum[C] = {};
        for (int k = 0; k < n; k += 8) {
          Eight far{};
          for (int c = 0; c < C; ++c) {
            const Eight d = *reinterpret_cast<const Eight*>(value[c] + k) - mean[c];
            far += d * d;
          }
          const Eight close = 1.0f + far * inverse;
          const Eight w = *reinterpret_cast<const Eight*>(weight + k) / (close * close);
          w_sum += w;
          for (int c = 0; c < C; ++c) sum[c] += w * *reinterpret_cast<const Eight*>(value[c] + k);
        }
        const float norm = 1 / sum_of(w_sum);
        for (int c = 0; c < C; ++c) mean[c] = sum_of(sum[c]) * norm;
        width = std::max(width * root, 1e-8f);
      }
    }
    const std::size_t voxel =
        (static_cast<std::size_t>(t.z) * static_cast<std::size_t>(size.y()) + static_cast<std::size_t>(t.y)) *
            static_cast<std::size_t>(size.x()) +
        static_cast<std::size_t>(x);
    for (int c = 0; c < C; ++c) t.field.channel[static_cast<std::size_t>(c)][voxel] = mean[c];
    if (!t.sources) continue;
    const float inverse = 1 / std::max(narrow, 1e-4f);
    int best = 0;
    float most = -1;
    for (int k = 0; k < used; ++k) {
      float far = 0;
      for (int c = 0; c < C; ++c) far += (value[c][k] - mean[c]) * (value[c][k] - mean[c]);
      const float w = weight[k] / ((1 + far * inverse) * (1 + far * inverse));
      if (w > most) most = w, best = k;
    }
    t.sources->texel[voxel] = texel[best], t.sources->exemplar[voxel] = from[best];
    if (t.features && !t.sources->features.empty()) {
      const auto* carried = (*t.features)[from[best]];
      if (carried && !carried->empty()) t.sources->features[voxel] = (*carried)[texel[best]];
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
                   const std::vector<MatchFamily>& families, const BlendSettings& settings, SolidField& field,
                   BlendSources* sources, const std::vector<const std::vector<Vec3f>*>* features,
                   const Work& work) {
  const std::array<std::vector<PatchCover>, 3> cover = {
      patch_covers(field.size.x()), patch_covers(field.size.y()), patch_covers(field.size.z())};
  blend_patches(exemplars, families, settings, {{&cover[0], &cover[1], &cover[2]}, Vec3i::Zero(), field.size},
                field, sources, features, work);
}

void blend_patches(const std::vector<const ExemplarLevel*>& exemplars,
                   const std::vector<MatchFamily>& families, const BlendSettings& settings,
                   const BlendRange& range, SolidField& field, BlendSources* sources,
                   const std::vector<const std::vector<Vec3f>*>* features, const Work& work) {
  static const bool avx2 = has_avx2();
  using Row = void (*)(const RowTask&);
  static const Row rows[2][4] = {{blend_plain<1>, blend_plain<2>, blend_plain<3>, blend_plain<4>},
                                 {blend_avx2<1>, blend_avx2<2>, blend_avx2<3>, blend_avx2<4>}};
  const Row row = rows[avx2][field.channel.size() - 1];
  // Squares of 8 × 8 rows share their patches in the cache.
  const int by = (range.hi.y() - range.lo.y() + 7) / 8, bz = (range.hi.z() - range.lo.z() + 7) / 8;
  work.parallel(static_cast<std::size_t>(by) * static_cast<std::size_t>(bz), 1,
                [&](std::size_t begin, std::size_t end) {
                  for (std::size_t i = begin; i < end; ++i) {
                    const int y0 = range.lo.y() + 8 * static_cast<int>(i % static_cast<std::size_t>(by)),
                              z0 = range.lo.z() + 8 * static_cast<int>(i / static_cast<std::size_t>(by));
                    for (int z = z0; z < std::min(z0 + 8, range.hi.z()); ++z)
                      for (int y = y0; y < std::min(y0 + 8, range.hi.y()); ++y)
                        row({exemplars, families, range, field, settings.window, sources, features, y, z});
                  }
                });
}

}  // namespace terrazzo::solid_optimize
