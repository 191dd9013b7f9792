#include "nodes/solids/synthesis/exemplar/finest_bands.h"

#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo::solids {
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
  row.resize(static_cast<std::size_t>(w) * height);
  out.resize(pixels_in(w, h));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < w; ++x) row[pixel_at(x, y, w)] = smoothed(&in[pixel_at(x, y, width)], gap);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::size_t i = pixel_at(x, y, w);
      out[i] = smoothed(&row[i], static_cast<std::ptrdiff_t>(w) * gap);
    }
}

}  // namespace

void FinestBands::split(int width, int height) {
  smooth(picture, width, height, 1, rows, once);
  const int less = width - 2 * kRadius;
  smooth(once, less, height - 2 * kRadius, 2, rows_again, twice);
  const int w = width - 2 * kFinishReach, h = height - 2 * kFinishReach;
  for (auto& b : band) b.resize(pixels_in(w, h));
  const auto at = [](const std::vector<float>& of, int wide, int x, int y) {
    return of[pixel_at(x, y, wide)];
  };
  std::size_t i = 0;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x, ++i) {
      const float all = at(picture, width, x + kFinishReach, y + kFinishReach),
                  row = at(rows, less, x + 2 * kRadius, y + kFinishReach),
                  low = at(once, less, x + 2 * kRadius, y + 2 * kRadius),
                  low_row = at(rows_again, w, x, y + 2 * kRadius);
      band[0][i] = all - row;
      band[1][i] = row - low;
      band[2][i] = low - low_row;
      band[3][i] = low_row - twice[i];
    }
}

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
            picture[static_cast<std::size_t>(y + kRadius) * e.width + (x + kRadius)] - low[pixel_at(x, y, w)];
        sum += d * d;
      }
  }
  return std::sqrt(sum / (static_cast<double>(w) * h));
}

std::vector<std::vector<Quantiles>> finest_bands(const SolidExemplar& e, int channels) {
  std::vector<std::vector<Quantiles>> out;
  FinestBands bands;
  for (int c = 0; c < channels; ++c) {
    bands.picture.clear();
    for (const auto& p : e.pixels) bands.picture.push_back(p[c]);
    bands.split(e.width, e.height);
    out.emplace_back();
    for (const auto& b : bands.band) out.back().push_back(quantiles_of(b));
  }
  return out;
}

}  // namespace terrazzo::solids
