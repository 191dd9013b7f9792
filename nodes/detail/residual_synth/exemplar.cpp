#include "nodes/detail/residual_synth/exemplar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/texture/band_statistics.h"

namespace terrazzo::residual_synth {
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

// Standard deviation of the values that a table represents. Tables lose a little of heavy tails.
double table_deviation(const Quantiles& q) {
  double first = 0, second = 0;
  for (std::size_t i = 0; i + 1 < q.at.size(); ++i) {
    const double a = q.at[i], b = q.at[i + 1];
    first += (a + b) / 2;
    second += (a * a + a * b + b * b) / 3;
  }
  const double n = q.at.size() - 1;
  return std::sqrt(std::max(0.0, second / n - first / n * (first / n)));
}

}  // namespace

Exemplar measure_exemplar(const std::vector<Image>& residuals, const std::array<int, 3>& picture, int scales,
                          int orientations, const Work& work) {
  Mat3 pooled = Mat3::Zero();
  for (const Image& r : residuals) {
    if (r.width < 16 || r.height < 16)
      throw Error("image-too-small", fmt::format("the photograph has {} × {} pixels", r.width, r.height),
                  "use at least 16 × 16 pixels");
    pooled += covariance(r, work.part(0, 0)) / static_cast<double>(residuals.size());
  }
  Exemplar out;
  out.scales = scales;
  out.picture = picture;
  const auto solver = eigen_axes(pooled);
  const double largest = solver.eigenvalues()[2];
  out.axes = principal_axes(solver);
  for (int c = 0; c < 3; ++c) {
    const double variance = solver.eigenvalues()[2 - c];
    if (variance > 1e-14 && variance > 1e-6 * largest) out.channels = c + 1;
  }
  if (out.channels == 0) return out;

  const Eigen::Matrix3f to_axes = out.axes.cast<float>().transpose();
  std::vector<BandStatistics> measured;
  for (std::size_t r = 0; r < residuals.size(); ++r) {
    // Rows run downwards in pictures but upwards in slices; flip so that slanted grain leans the same way.
    const Image& from = residuals[r];
    Image rotated(from.width, from.height, from.sections, from.pixel_size);
    for (int s = 0; s < from.sections; ++s)
      for (int y = 0; y < from.height; ++y)
        for (int x = 0; x < from.width; ++x)
          rotated.at(x, from.height - 1 - y, s) = to_axes * from.at(x, y, s);
    const double n = residuals.size();
    measured.push_back(
        measure_bands(rotated, out.channels, scales, work.part(r / n, (r + 1) / n), orientations));
    out.bands.push_back(measured.back().bands);
    // Give values the deviation of all bands together; otherwise matching values undoes matching bands.
    for (std::size_t c = 0; c < static_cast<std::size_t>(out.channels); ++c) {
      Quantiles& values = measured.back().values[c];
      const double given = table_deviation(values);
      if (given > 0) {
        values.widen(measured.back().deviation[c] / given);
        values.deviation = measured.back().deviation[c];
      }
    }
  }
  for (std::size_t c = 0; c < static_cast<std::size_t>(out.channels); ++c) {
    std::vector<const Quantiles*> values;
    for (const int p : picture) values.push_back(&measured[p].values[c]);
    const bool one = picture[0] == picture[1] && picture[1] == picture[2];
    out.values.push_back(one ? *values[0] : mixture(values));
  }
  return out;
}

}  // namespace terrazzo::residual_synth
