#include "nodes/textures/texture_set/broken_face.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>

#include "nodes/common/geometry/periodic.h"
#include "runtime/random.h"

namespace terrazzo::texture_set {

BrokenFace::BrokenFace(double width, double height, double texel, double grain, double deviation,
                       std::uint64_t seed, const Work& work)
    : width_(width), height_(height) {
  constexpr int kMost = 4096;  // finer waves would be lower than 1/1,000 of the deviation
  columns_ = std::clamp(round_up(width / texel), 2, kMost);
  rows_ = std::clamp(round_up(height / texel), 2, kMost);
  cv::Mat waves(rows_, columns_, CV_32FC2, cv::Scalar(0, 0));
  const double longest = 4 * grain;
  // Fills the waves with row number j, and returns their power.
  const auto fill = [&](int j) {
    double power = 0;
    for (int i = -(columns_ - 1) / 2; i <= (columns_ - 1) / 2; ++i) {
      const double k = std::hypot(i / width, j / height);
      if (k == 0) continue;
      const double amplitude = std::pow(std::max(k * longest, 1.0), -1.8);
      power += amplitude * amplitude / 2;
      const std::uint64_t item =
          static_cast<std::uint64_t>(j + kMost) * (2 * kMost) + static_cast<std::uint64_t>(i + kMost);
      const double phase = Random(seed, 0x66616365, item).uniform(0, 2 * std::numbers::pi);
      waves.at<cv::Vec2f>(wrap_index(j, rows_), wrap_index(i, columns_)) =
          cv::Vec2f(amplitude * std::cos(phase), amplitude * std::sin(phase));
    }
    return power;
  };
  const int first = -(rows_ - 1) / 2, rows = 2 * ((rows_ - 1) / 2) + 1;
  const double power = work.quiet().reduce(
      rows, 16, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t row = begin; row < end; ++row) sum += fill(first + static_cast<int>(row));
        return sum;
      },
      std::plus<>());
  cv::dft(waves, waves, cv::DFT_INVERSE);
  work.check();
  const double scale = power > 0 ? deviation / std::sqrt(power) : 0;
  for (int j = 0; j < rows_; ++j)
    for (int i = 0; i < columns_; ++i)
      mm_.push_back(static_cast<float>(scale * waves.at<cv::Vec2f>(j, i)[0]));
  lowest_ = *std::min_element(mm_.begin(), mm_.end());
  highest_ = *std::max_element(mm_.begin(), mm_.end());
}

double BrokenFace::at(double u, double v) const {
  const double x = u / width_ * columns_, y = v / height_ * rows_;
  const int i = round_down(x), j = round_down(y);
  const double s = x - i, t = y - j;
  const auto value = [&](int a, int b) {
    return double{mm_[pixel_at(wrap_index(a, columns_), wrap_index(b, rows_), columns_)]};
  };
  return (1 - t) * ((1 - s) * value(i, j) + s * value(i + 1, j)) +
         t * ((1 - s) * value(i, j + 1) + s * value(i + 1, j + 1));
}

}  // namespace terrazzo::texture_set
