#include "nodes/common/texture/band_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/texture/steerable_pyramid.h"
#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

// Replaces the spectrum of an image by that of its periodic component: subtracts the smooth solution of
// Poisson's equation whose source is the jumps across the borders.
void make_periodic(std::vector<LaneComplex>& spectrum, const std::vector<LaneComplex>& picture,
                   const LaneFft2& fft, std::vector<LaneComplex>& scratch) {
  const int w = fft.width(), h = fft.height();
  const auto at = [&](int x, int y) { return pixel_at(x, y, w); };
  std::vector<LaneComplex> jumps(fft.count());
  for (auto& j : jumps) {
    j.re = Lane{};
    j.im = Lane{};
  }
  for (int x = 0; x < w; ++x) {
    const Lane d = picture[at(x, h - 1)].re - picture[at(x, 0)].re;
    jumps[at(x, 0)].re += d;
    jumps[at(x, h - 1)].re -= d;
  }
  for (int y = 0; y < h; ++y) {
    const Lane d = picture[at(w - 1, y)].re - picture[at(0, y)].re;
    jumps[at(0, y)].re += d;
    jumps[at(w - 1, y)].re -= d;
  }
  fft.run(jumps.data(), false, scratch);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (x == 0 && y == 0) continue;
      const float k =
          1 / (2 * std::cos(2 * std::numbers::pi * x / w) + 2 * std::cos(2 * std::numbers::pi * y / h) - 4);
      spectrum[at(x, y)].re -= jumps[at(x, y)].re * k;
      spectrum[at(x, y)].im -= jumps[at(x, y)].im * k;
    }
}

}  // namespace

BandStatistics measure_bands(const Image& image, int channels, int scales, const Work& work,
                             int orientations) {
  BandStatistics out;
  constexpr int kLargestSide = 720;
  const int sections = std::min(image.sections, 8);
  const double side = kLargestSide / std::sqrt(static_cast<double>(sections));
  const int w = out.width = fast_size_below(std::min(image.width, std::max<int>(16, side)));
  const int h = out.height = fast_size_below(std::min(image.height, std::max<int>(16, side)));
  const int x0 = (image.width - w) / 2, y0 = (image.height - h) / 2;
  const LaneFft2 fft(w, h);
  const auto bands = pyramid_bands(w, h, scales, orientations);

  std::vector<std::vector<LaneComplex>> spectra(sections), pictures(sections);
  work.part(0, 0.3).parallel(sections, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch;
    for (std::size_t s = begin; s < end; ++s) {
      const int section = s * image.sections / sections;
      auto& picture = pictures[s];
      picture.resize(fft.count());
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          const Vec3f& v = image.at(x0 + x, y0 + y, section);
          auto& p = picture[pixel_at(x, y, w)];
          p.re = Lane{v[0], v[1], v[2], 0};
          p.im = Lane{};
        }
      spectra[s] = picture;
      fft.run(spectra[s].data(), false, scratch);
      make_periodic(spectra[s], picture, fft, scratch);
    }
  });

  const auto values_of = [&](const std::vector<std::vector<LaneComplex>>& all, int c) {
    std::vector<float> v;
    for (const auto& a : all)
      for (const auto& p : a) v.push_back(p.re[c]);
    return v;
  };
  for (int c = 0; c < channels; ++c) out.values.push_back(quantiles_of(values_of(pictures, c)));
  // Parseval: Σ |spectrum|² / count² is the mean square.
  for (int c = 0; c < channels; ++c) {
    double square = 0;
    for (const auto& spectrum : spectra)
      for (std::size_t i = 1; i < spectrum.size(); ++i) {
        const double re = spectrum[i].re[c], im = spectrum[i].im[c];
        square += re * re + im * im;
      }
    out.deviation.push_back(std::sqrt(square / sections) / fft.count());
  }
  out.bands.assign(channels, std::vector<Quantiles>(bands.size()));
  work.part(0.3, 1).parallel(bands.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch;
    for (std::size_t b = begin; b < end; ++b) {
      const LaneFft2 crop(bands[b].width, bands[b].height);
      std::vector<std::vector<LaneComplex>> images(sections);
      for (int s = 0; s < sections; ++s) {
        images[s].resize(crop.count());
        extract_band(bands[b], crop, spectra[s].data(), fft.count(), images[s].data(), scratch);
      }
      for (int c = 0; c < channels; ++c) out.bands[c][b] = quantiles_of(values_of(images, c));
    }
  });
  return out;
}

}  // namespace terrazzo
