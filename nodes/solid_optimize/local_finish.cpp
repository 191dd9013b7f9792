#include "nodes/solid_optimize/local_finish.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "nodes/common/slice_axes.h"
#include "nodes/solid_optimize/finish.h"
#include "nodes/solid_optimize/levels.h"

namespace terrazzo::solid_optimize {
namespace {

constexpr int kRadius = 3;  // of the smoothing filter, in steps
static_assert(kFinishReach == kRadius + 2 * kRadius);

// (1 −6 15 44 15 −6 1)/64 around p[3 · step]: 1 − sin⁶(ω/2), flat up to a quarter of the sampling rate and 0
// at half of it. Binomial filters leak so much of the lower frequencies into the finest band that it came out
// twice too strong where the exemplar has almost none.
inline float smoothed(const float* p, std::ptrdiff_t step) {
  return 0.015625f * (44 * p[3 * step] + 15 * (p[2 * step] + p[4 * step]) - 6 * (p[step] + p[5 * step]) +
                      (p[0] + p[6 * step]));
}

// Smooths a picture with steps of `gap`; out is smaller by kRadius · gap on all sides.
void smooth(const std::vector<float>& in, int width, int height, int gap, std::vector<float>& row,
            std::vector<float>& out) {
  const int w = width - 2 * kRadius * gap, h = height - 2 * kRadius * gap;
  row.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(height));
  out.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < w; ++x)
      row[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] = smoothed(
          &in[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)],
          gap);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
      out[i] = smoothed(&row[i], static_cast<std::ptrdiff_t>(w) * gap);
    }
}

// The bands of a picture of width × height, without a margin of kFinishReach.
struct Bands {
  std::vector<float> picture, rows, once, rows_again, twice;
  std::array<std::vector<float>, kFinishBands> band;

  void split(int width, int height) {
    smooth(picture, width, height, 1, rows, once);
    const int less = width - 2 * kRadius;
    smooth(once, less, height - 2 * kRadius, 2, rows_again, twice);
    const int w = width - 2 * kFinishReach, h = height - 2 * kFinishReach;
    for (auto& b : band) b.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    const auto at = [](const std::vector<float>& of, int wide, int x, int y) {
      return of[static_cast<std::size_t>(y) * static_cast<std::size_t>(wide) + static_cast<std::size_t>(x)];
    };
    std::size_t i = 0;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x, ++i) {
        const float all = at(picture, width, x + kFinishReach, y + kFinishReach),
                    row = at(rows, less, x + 2 * kRadius, y + kFinishReach),
                    low = at(once, less, x + 2 * kRadius, y + 2 * kRadius),
                    low_row = at(rows_again, w, x, y + 2 * kRadius);
        band[0][i] = all - row, band[1][i] = row - low;
        band[2][i] = low - low_row, band[3][i] = low_row - twice[i];
      }
  }
};

struct Strides {
  std::array<std::size_t, 3> step;
  Vec3i from;
  explicit Strides(const LocalRegion& r)
      : step{1, static_cast<std::size_t>(r.field.size.x()),
             static_cast<std::size_t>(r.field.size.x()) * static_cast<std::size_t>(r.field.size.y())},
        from(r.lines[0].from, r.lines[1].from, r.lines[2].from) {}
  std::size_t of(const Vec3i& at) const {
    std::size_t i = 0;
    for (int a = 0; a < 3; ++a)
      i += static_cast<std::size_t>(at[a] - from[a]) * step[static_cast<std::size_t>(a)];
    return i;
  }
};

// Splits one slice of a box into bands.
void split_slice(const LocalRegion& region, int channel, int axis, int slice, const LocalBox& box,
                 Bands& bands) {
  const Strides strides(region);
  const int u = kSliceColumns[static_cast<std::size_t>(axis)], v = kSliceRows[static_cast<std::size_t>(axis)];
  const int w = box.hi[u] - box.lo[u] + 2 * kFinishReach, h = box.hi[v] - box.lo[v] + 2 * kFinishReach;
  bands.picture.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  Vec3i at;
  at[axis] = slice, at[u] = box.lo[u] - kFinishReach, at[v] = box.lo[v] - kFinishReach;
  const float* first = &region.field.channel[static_cast<std::size_t>(channel)][strides.of(at)];
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      bands.picture[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
          first[static_cast<std::size_t>(y) * strides.step[static_cast<std::size_t>(v)] +
                static_cast<std::size_t>(x) * strides.step[static_cast<std::size_t>(u)]];
  bands.split(w, h);
}

}  // namespace

double finest_deviation(const SolidExemplar& e, int channels) {
  const int w = e.width - 2 * kRadius, h = e.height - 2 * kRadius;
  std::vector<float> picture(e.pixels.size()), row, low;
  double sum = 0;
  for (int c = 0; c < channels; ++c) {
    for (std::size_t i = 0; i < picture.size(); ++i) picture[i] = e.pixels[i][c];
    smooth(picture, e.width, e.height, 1, row, low);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const double d =
            picture[static_cast<std::size_t>(y + kRadius) * static_cast<std::size_t>(e.width) +
                    static_cast<std::size_t>(x + kRadius)] -
            low[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)];
        sum += d * d;
      }
  }
  return std::sqrt(sum / (static_cast<double>(w) * h));
}

std::vector<std::vector<Quantiles>> finest_bands(const SolidExemplar& e, int channels) {
  std::vector<std::vector<Quantiles>> out;
  Bands bands;
  for (int c = 0; c < channels; ++c) {
    bands.picture.clear();
    for (const auto& p : e.pixels) bands.picture.push_back(p[c]);
    bands.split(e.width, e.height);
    out.emplace_back();
    for (const auto& b : bands.band) out.back().push_back(quantiles_of(b));
  }
  return out;
}

void finish_round(const std::vector<std::vector<std::vector<Quantiles>>>& wanted, const Quantiles& values,
                  int channel, const LocalBox& box, const LocalBox* measured, FinishMaps& maps,
                  LocalRegion& region, const Work& work) {
  const auto c = static_cast<std::size_t>(channel);
  if (measured) {
    maps.bands.clear();
    for (const MatchFamily& f : region.families) {
      const Vec3i extent = measured->size();
      const auto slices = static_cast<std::size_t>(extent[f.axis]);
      const std::size_t each = voxels(extent) / slices;
      std::array<std::vector<float>, kFinishBands> seen;
      for (auto& values : seen) values.resize(each * slices);
      work.parallel(slices, 4, [&](std::size_t begin, std::size_t end) {
        Bands bands;
        for (std::size_t s = begin; s < end; ++s) {
          split_slice(region, channel, f.axis, measured->lo[f.axis] + static_cast<int>(s), *measured, bands);
          for (std::size_t b = 0; b < kFinishBands; ++b)
            std::copy(bands.band[b].begin(), bands.band[b].end(),
                      seen[b].begin() + static_cast<std::ptrdiff_t>(s * each));
        }
      });
      std::array<std::optional<ValueMap>, kFinishBands> fixed;
      work.parallel(kFinishBands, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b)
          fixed[b].emplace(seen[b], wanted[static_cast<std::size_t>(f.exemplar)][c][b]);
      });
      maps.bands.emplace_back();
      for (const auto& m : fixed) maps.bands.back().push_back(*m);
    }
  }
  const float share = finish_share(region.families.size());
  const Strides strides(region);
  std::vector<float> sum = region.field.channel[c];
  for (std::size_t k = 0; k < region.families.size(); ++k) {
    const int axis = region.families[k].axis;
    const int u = kSliceColumns[static_cast<std::size_t>(axis)],
              v = kSliceRows[static_cast<std::size_t>(axis)];
    work.parallel(static_cast<std::size_t>(box.hi[axis] - box.lo[axis]), 4,
                  [&](std::size_t begin, std::size_t end) {
                    Bands bands;
                    std::vector<float> mapped;
                    for (std::size_t i = begin; i < end; ++i) {
                      const int slice = box.lo[axis] + static_cast<int>(i);
                      split_slice(region, channel, axis, slice, box, bands);
                      Vec3i at = box.lo;
                      at[axis] = slice;
                      float* first = &sum[strides.of(at)];
                      const int w = box.hi[u] - box.lo[u], h = box.hi[v] - box.lo[v];
                      for (std::size_t b = 0; b < kFinishBands; ++b) {
                        mapped = bands.band[b];
                        maps.bands[k][b].apply(mapped.data(), mapped.size());
                        std::size_t n = 0;
                        for (int y = 0; y < h; ++y)
                          for (int x = 0; x < w; ++x, ++n)
                            first[static_cast<std::size_t>(y) * strides.step[static_cast<std::size_t>(v)] +
                                  static_cast<std::size_t>(x) * strides.step[static_cast<std::size_t>(u)]] +=
                                share * (mapped[n] - bands.band[b][n]);
                      }
                    }
                  });
  }
  region.field.channel[c].swap(sum);
  if (measured) {
    maps.values.clear();
    maps.values.emplace_back(values_in(*measured, region, channel), values);
  }
  auto& all = region.field.channel[c];
  work.parallel(all.size(), 1 << 16,
                [&](std::size_t b, std::size_t e) { maps.values[0].apply(all.data() + b, e - b); });
  copy_beyond(region.lines, all, work);
}

}  // namespace terrazzo::solid_optimize
