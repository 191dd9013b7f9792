#include "nodes/residual_synth/exemplar.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/residual_synth/pyramid.h"

namespace terrazzo {
namespace {

Mat3 covariance(const Image& image, const Work& work) {
  const Mat3 sum = work.reduce<Mat3>(
      image.pixels.size(), 1 << 14, Mat3::Zero(),
      [&](std::size_t b, std::size_t e) {
        Mat3 s = Mat3::Zero();
        for (std::size_t i = b; i < e; ++i) {
          const Vec3 v = image.pixels[i].cast<double>();
          s += v * v.transpose();
        }
        return s;
      },
      [](const Mat3& a, const Mat3& b) -> Mat3 { return a + b; });
  return sum / static_cast<double>(image.pixels.size());
}

// Turns the spectrum of a picture into that of its periodic component: less the smooth solution of Poisson's
// equation whose source are the jumps across the borders.
void make_periodic(std::vector<LaneComplex>& spectrum, const std::vector<LaneComplex>& picture,
                   const LaneFft2& fft, std::vector<LaneComplex>& scratch) {
  const int w = fft.width(), h = fft.height();
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(y) * w + x; };
  std::vector<LaneComplex> jumps(fft.count());
  for (auto& j : jumps) j.re = Lane{}, j.im = Lane{};
  for (int x = 0; x < w; ++x) {
    const Lane d = picture[at(x, h - 1)].re - picture[at(x, 0)].re;
    jumps[at(x, 0)].re += d, jumps[at(x, h - 1)].re -= d;
  }
  for (int y = 0; y < h; ++y) {
    const Lane d = picture[at(w - 1, y)].re - picture[at(0, y)].re;
    jumps[at(0, y)].re += d, jumps[at(w - 1, y)].re -= d;
  }
  fft.run(jumps.data(), false, scratch);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (x == 0 && y == 0) continue;
      const float k = static_cast<float>(
          1 / (2 * std::cos(2 * std::numbers::pi * x / w) + 2 * std::cos(2 * std::numbers::pi * y / h) - 4));
      spectrum[at(x, y)].re -= jumps[at(x, y)].re * k, spectrum[at(x, y)].im -= jumps[at(x, y)].im * k;
    }
}

}  // namespace

Exemplar measure_exemplar(const Image& residual, int scales, const Work& work) {
  if (residual.width < 16 || residual.height < 16)
    throw Error("image-too-small",
                fmt::format("the photograph has {} × {} pixels", residual.width, residual.height),
                "the residual's statistics need 16 × 16 at least");
  Exemplar out;
  out.scales = scales;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance(residual, work));
  const double largest = solver.eigenvalues()[2];
  for (int c = 0; c < 3; ++c) {
    Vec3 axis = solver.eigenvectors().col(2 - c);
    Eigen::Index i;
    axis.cwiseAbs().maxCoeff(&i);
    out.axes.col(c) = axis[i] < 0 ? Vec3(-axis) : axis;  // the solver's sign is arbitrary
    const double variance = solver.eigenvalues()[2 - c];
    if (variance > 1e-14 && variance > 1e-6 * largest) out.channels = c + 1;
  }
  if (out.channels == 0) return out;

  constexpr int largest_side = 720;
  const int sections = std::min(residual.sections, 8);
  const double side = largest_side / std::sqrt(static_cast<double>(sections));
  const int w = out.width = fast_size_below(std::min(residual.width, std::max(16, static_cast<int>(side))));
  const int h = out.height = fast_size_below(std::min(residual.height, std::max(16, static_cast<int>(side))));
  const int x0 = (residual.width - w) / 2, y0 = (residual.height - h) / 2;
  const LaneFft2 fft(w, h);
  const auto bands = pyramid_bands(w, h, scales);

  std::vector<std::vector<LaneComplex>> spectra(sections), pictures(sections);
  work.part(0, 0.3).parallel(sections, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch;
    for (std::size_t s = begin; s < end; ++s) {
      const int section = static_cast<int>(s * residual.sections / sections);
      auto& picture = pictures[s];
      picture.resize(fft.count());
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          const Vec3f v = out.axes.cast<float>().transpose() * residual.at(x0 + x, y0 + y, section);
          auto& p = picture[static_cast<std::size_t>(y) * w + x];
          p.re = Lane{v[0], v[1], v[2], 0}, p.im = Lane{};
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
  for (int c = 0; c < out.channels; ++c) out.values.push_back(quantiles_of(values_of(pictures, c)));
  out.bands.assign(out.channels, std::vector<Quantiles>(bands.size()));
  work.part(0.3, 1).parallel(bands.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch;
    for (std::size_t b = begin; b < end; ++b) {
      const LaneFft2 crop(bands[b].width, bands[b].height);
      std::vector<std::vector<LaneComplex>> images(sections);
      for (int s = 0; s < sections; ++s) {
        images[s].resize(crop.count());
        extract_band(bands[b], crop, spectra[s].data(), fft.count(), images[s].data(), scratch);
      }
      for (int c = 0; c < out.channels; ++c) out.bands[c][b] = quantiles_of(values_of(images, c));
    }
  });
  return out;
}

}  // namespace terrazzo
