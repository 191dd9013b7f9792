#include "nodes/residual_synth/exemplar.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "nodes/common/band_statistics.h"
#include "nodes/common/principal_axes.h"

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
  out.axes = principal_axes(solver);
  for (int c = 0; c < 3; ++c) {
    const double variance = solver.eigenvalues()[2 - c];
    if (variance > 1e-14 && variance > 1e-6 * largest) out.channels = c + 1;
  }
  if (out.channels == 0) return out;

  Image rotated = residual;
  const Eigen::Matrix3f to_axes = out.axes.cast<float>().transpose();
  for (auto& p : rotated.pixels) p = to_axes * p;
  const BandStatistics s = measure_bands(rotated, out.channels, scales, work);
  out.values = s.values, out.bands = s.bands, out.width = s.width, out.height = s.height;
  return out;
}

}  // namespace terrazzo
