#include "nodes/photograph/segment/network/sharpness.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "nodes/common/geometry/rank.h"
#include "nodes/photograph/segment/network/network.h"

namespace terrazzo::segment {
namespace {

constexpr int kWindow = 1024, kWindows = 3;  // pixels; along each axis

struct Gradients {
  std::vector<float> fine, coarse;  // squares, before and after a blur of one pixel
};

void add_squares(const cv::Mat& light, std::vector<float>& out) {
  cv::Mat x, y;
  cv::Sobel(light, x, CV_32F, 1, 0, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
  cv::Sobel(light, y, CV_32F, 0, 1, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
  const cv::Mat squares = x.mul(x) + y.mul(y);
  for (int row = 0; row < squares.rows; ++row)
    out.insert(out.end(), squares.ptr<float>(row), squares.ptr<float>(row) + squares.cols);
}

void add_gradients(const cv::Mat& window, double scale, Gradients& all) {
  cv::Mat light, blurred;
  cv::cvtColor(window, light, cv::COLOR_RGB2GRAY);
  if (scale < 1) cv::resize(light, light, {}, scale, scale, cv::INTER_AREA);
  cv::GaussianBlur(light, blurred, {}, 1.0, 1.0, cv::BORDER_REPLICATE);
  add_squares(light, all.fine);
  add_squares(blurred, all.coarse);
}

// The first pixels of evenly spread windows along a side.
std::vector<int> starts(int side) {
  const int count = std::clamp((side + kWindow - 1) / kWindow, 1, kWindows);
  std::vector<int> out;
  for (int k = 0; k < count; ++k)
    out.push_back(count == 1 ? 0
                             : static_cast<int>(static_cast<std::int64_t>(side - kWindow) * k / (count - 1)));
  return out;
}

float quantile(std::vector<float> values, double q) {
  return at_rank(values, static_cast<std::size_t>(q * (values.size() - 1)));
}

}  // namespace

double blur_of(const Image& image, double scale) {
  constexpr double kStrong = 0.97, kWeak = 0.5;
  Gradients g;
  for (const int y : starts(image.height))
    for (const int x : starts(image.width)) {
      const cv::Rect window = cv::Rect(x, y, kWindow, kWindow) & cv::Rect(0, 0, image.width, image.height);
      add_gradients(encoded_window(image, 0, window), scale, g);
    }
  const float strong = quantile(g.coarse, kStrong), weak = quantile(g.coarse, kWeak);
  double edge_fine = 0, edge_coarse = 0, noise_fine = 0, noise_coarse = 0, edges = 0, noises = 0;
  for (std::size_t i = 0; i < g.coarse.size(); ++i) {
    const double fine = g.fine[i], coarse = g.coarse[i];
    if (g.coarse[i] >= strong) {
      edge_fine += fine;
      edge_coarse += coarse;
      ++edges;
    }
    if (g.coarse[i] <= weak) {
      noise_fine += fine;
      noise_coarse += coarse;
      ++noises;
    }
  }
  const double before = edge_fine / edges - noise_fine / noises,
               after = edge_coarse / edges - noise_coarse / noises;
  if (!(after > 0) || before <= after) return 0;  // no edges: nothing to be sharp
  return 1 / std::sqrt(before / after - 1);
}

double network_scale_of(const Image& image) {
  constexpr double kSoft = 1.5, kSharp = 1.15, kWanted = 1.05, kShortest = 512;
  constexpr int kRounds = 4;
  const double least = std::min(1.0, kShortest / std::min(image.width, image.height));
  double scale = 1;
  for (int round = 0; round < kRounds && scale > least; ++round) {
    const double blur = blur_of(image, scale);
    if (blur <= (round == 0 ? kSoft : kSharp)) break;
    scale = std::max(least, scale * std::max(0.5, kWanted / blur));
  }
  return scale;
}

}  // namespace terrazzo::segment
