#include "nodes/common/texture/steerable_pyramid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

constexpr double kPi = std::numbers::pi;

// 1 up to `edge`/2, 0 from `edge` on.
double low_pass(double r, double edge) {
  if (r <= edge / 2) return 1;
  if (r >= edge) return 0;
  return std::cos(kPi / 2 * std::log2(2 * r / edge));
}
double high_pass(double r, double edge) {
  const double l = low_pass(r, edge);
  return std::sqrt(std::max(0.0, 1 - l * l));
}

// Size of a grid that holds all frequencies of n samples below `edge` (radians per pixel).
int cropped(int n, double edge) {
  if (edge >= kPi) return n;
  return std::min(n, fast_even_size_above(round_up(n * edge / kPi)));
}

int signed_frequency(int i, int n) { return 2 * i < n ? i : i - n; }

}  // namespace

int pyramid_scales(int smallest_side, int most) {
  int scales = 1;
  while (scales < most && smallest_side >> (scales + 1) >= 4) ++scales;
  return scales;
}

double upper_edge(int scale) { return scale == 0 ? 4 * kPi : kPi / (1 << (scale - 1)); }

double radial_gain(int scale, int scales, double r) {
  const double top = upper_edge(scale);
  if (scale == 0) return high_pass(r, kPi);
  return low_pass(r, top) * (scale > scales ? 1 : high_pass(r, top / 2));
}

double band_gain(int scale, int orientation, int scales, double u, double v) {
  const double r = std::hypot(u, v), radial = radial_gain(scale, scales, r);
  if (scale == 0 || scale > scales) return radial;
  const double c =
      r > 0 ? (u * std::cos(orientation * kPi / 4) + v * std::sin(orientation * kPi / 4)) / r : 0;
  return radial * c * c * c / std::sqrt(1.25);
}

std::vector<Band> pyramid_bands(int width, int height, int scales, int orientations) {
  std::vector<Band> bands;
  for (int scale = 0; scale <= scales + 1; ++scale)
    for (int o = 0; o < (scale == 0 || scale > scales ? 1 : orientations); ++o) {
      Band b;
      b.scale = scale;
      b.orientation = o;
      b.odd = orientations > 1 && scale > 0 && scale <= scales;
      b.width = cropped(width, upper_edge(scale));
      b.height = cropped(height, upper_edge(scale));
      b.gain.resize(pixels_in(b.width, b.height));
      b.source.resize(b.gain.size());
      for (int y = 0; y < b.height; ++y)
        for (int x = 0; x < b.width; ++x) {
          const int fx = signed_frequency(x, b.width), fy = signed_frequency(y, b.height);
          const double u = 2 * kPi * fx / width, v = 2 * kPi * fy / height;
          const double g = orientations == 1 ? radial_gain(scale, scales, std::hypot(u, v))
                                             : band_gain(scale, o, scales, u, v);
          const std::size_t at = pixel_at(x, y, b.width);
          b.gain[at] = g;
          b.source[at] = static_cast<std::size_t>((fy + height) % height) * width + (fx + width) % width;
        }
      bands.push_back(std::move(b));
    }
  return bands;
}

void extract_band(const Band& b, const LaneFft2& crop, const LaneComplex* spectrum, std::size_t full_count,
                  LaneComplex* out, std::vector<LaneComplex>& scratch) {
  const float norm = 1.0f / full_count;
  for (std::size_t i = 0; i < b.gain.size(); ++i) {
    const float g = b.gain[i] * norm;
    const LaneComplex& s = spectrum[b.source[i]];
    if (b.odd) {
      out[i].re = -s.im * g;
      out[i].im = s.re * g;
    } else {
      out[i].re = s.re * g;
      out[i].im = s.im * g;
    }
  }
  crop.run(out, true, scratch);
}

void add_band(const Band& b, const LaneFft2& crop, LaneComplex* values, std::size_t full_count,
              LaneComplex* spectrum, std::vector<LaneComplex>& scratch) {
  crop.run(values, false, scratch);
  const float norm = static_cast<float>(full_count) / crop.count();
  for (std::size_t i = 0; i < b.gain.size(); ++i) {
    if (b.gain[i] == 0) continue;
    const float g = b.gain[i] * norm;
    LaneComplex& s = spectrum[b.source[i]];
    if (b.odd) {
      s.re += values[i].im * g;
      s.im -= values[i].re * g;
    } else {
      s.re += values[i].re * g;
      s.im += values[i].im * g;
    }
  }
}

}  // namespace terrazzo
