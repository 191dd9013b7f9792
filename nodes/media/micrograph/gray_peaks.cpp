#include "nodes/media/micrograph/gray_peaks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace terrazzo::media {
namespace {

constexpr float kRounding = 0.0136f;  // two steps of 8 bits in each channel, which rounding and dither make
constexpr int kBins = 256;
constexpr double kFlat = 0.5;        // share of the pixels, those with the smallest gradients
constexpr double kSmooth = 4;        // bins, of the histogram whose peaks count
constexpr double kStep = 1.5 / 255;  // and more than a step of 8 bits
constexpr double kValley = 0.5;      // of the lower of two peaks
constexpr double kLeastPeak = 0.01;  // of the highest
constexpr std::size_t kMostPeaks = 5;

struct Histogram {
  double low = 0, width = 1;  // of a bin
  std::vector<double> count = std::vector<double>(kBins, 0);
  double level(double bin) const { return low + (bin + 0.5) * width; }
};

Histogram histogram_of(const std::vector<float>& values) {
  Histogram out;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  out.low = *low;
  out.width = std::max(1e-6f, *high - *low) / kBins;
  for (const float v : values) ++out.count[std::min(kBins - 1, static_cast<int>((v - out.low) / out.width))];
  return out;
}

// Gray levels of pixels inside phases, a little smoothed.
std::vector<float> inside(const cv::Mat1f& gray, const std::vector<std::uint8_t>& observed) {
  cv::Mat1f smooth, dx, dy;
  cv::GaussianBlur(gray, smooth, {5, 5}, 0, 0, cv::BORDER_REPLICATE);
  cv::Sobel(smooth, dx, CV_32F, 1, 0);
  cv::Sobel(smooth, dy, CV_32F, 0, 1);
  std::vector<float> slope;
  for (std::size_t i = 0; i < observed.size(); ++i)
    if (observed[i]) slope.push_back(std::hypot(dx.ptr<float>()[i], dy.ptr<float>()[i]));
  std::vector<float> sorted = slope;
  const auto limit = sorted.begin() + static_cast<std::ptrdiff_t>(kFlat * (sorted.size() - 1));
  std::nth_element(sorted.begin(), limit, sorted.end());
  std::vector<float> out;
  std::size_t k = 0;
  for (std::size_t i = 0; i < observed.size(); ++i)
    if (observed[i] && slope[k++] <= *limit) out.push_back(smooth.ptr<float>()[i]);
  return out;
}

std::vector<double> peaks_of(const Histogram& h) {
  cv::Mat1d row(1, kBins);
  std::copy(h.count.begin(), h.count.end(), row.begin());
  const double sigma = std::clamp(kStep / h.width, kSmooth, kBins / 8.0);
  cv::GaussianBlur(row, row, {0, 0}, sigma, sigma, cv::BORDER_CONSTANT);
  const double* v = row.ptr<double>();
  const double highest = *std::max_element(v, v + kBins);
  // Peaks in order; of two without a valley between, the higher remains.
  std::vector<int> peaks;
  for (int i = 0; i < kBins; ++i) {
    const double before = i > 0 ? v[i - 1] : -1, after = i < kBins - 1 ? v[i + 1] : -1;
    if (v[i] <= before || v[i] < after || v[i] < kLeastPeak * highest) continue;
    bool is_new = true;
    while (!peaks.empty()) {
      const int last = peaks.back();
      const double valley = *std::min_element(v + last, v + i + 1);
      if (valley <= kValley * std::min(v[last], v[i])) break;
      if (v[last] >= v[i]) {
        is_new = false;
        break;
      }
      peaks.pop_back();
    }
    if (is_new) peaks.push_back(i);
  }
  if (peaks.size() > kMostPeaks) {
    std::stable_sort(peaks.begin(), peaks.end(), [&](int a, int b) { return v[a] > v[b]; });
    peaks.resize(kMostPeaks);
    std::sort(peaks.begin(), peaks.end());
  }
  std::vector<double> out;
  for (const int p : peaks) out.push_back(h.level(p));
  return out;
}

// Means of the classes whose thresholds leave the least variance within, by dynamic programming.
std::vector<double> otsu(const Histogram& h, int phases) {
  std::vector<double> n(kBins + 1, 0), sum(kBins + 1, 0), squares(kBins + 1, 0);
  for (int i = 0; i < kBins; ++i) {
    const double level = h.level(i);
    n[i + 1] = n[i] + h.count[i];
    sum[i + 1] = sum[i] + h.count[i] * level;
    squares[i + 1] = squares[i] + h.count[i] * level * level;
  }
  const auto within = [&](int from, int to) {
    const double c = n[to] - n[from], s = sum[to] - sum[from];
    return c > 0 ? squares[to] - squares[from] - s * s / c : 0;
  };
  std::vector<std::vector<double>> best(phases, std::vector<double>(kBins + 1, 0));
  std::vector<std::vector<int>> cut(phases, std::vector<int>(kBins + 1, 0));
  for (int to = 0; to <= kBins; ++to) best[0][to] = within(0, to);
  for (int k = 1; k < phases; ++k)
    for (int to = 0; to <= kBins; ++to) {
      best[k][to] = 1e300;
      for (int from = 0; from <= to; ++from)
        if (const double e = best[k - 1][from] + within(from, to); e < best[k][to]) {
          best[k][to] = e;
          cut[k][to] = from;
        }
    }
  std::vector<double> out(phases);
  for (int k = phases - 1, to = kBins; k >= 0; --k) {
    const int from = k > 0 ? cut[k][to] : 0;
    const double c = n[to] - n[from];
    out[k] = c > 0 ? (sum[to] - sum[from]) / c : h.level(from);
    to = from;
  }
  return out;
}

}  // namespace

std::vector<double> gray_levels(const cv::Mat1f& gray, const std::vector<std::uint8_t>& observed,
                                int phases) {
  std::vector<float> all;
  for (std::size_t i = 0; i < observed.size(); ++i)
    if (observed[i]) all.push_back(gray.ptr<float>()[i]);
  const float range = *std::max_element(all.begin(), all.end()) - *std::min_element(all.begin(), all.end());
  if (range < (phases > 0 ? 1e-6f : kRounding)) return {};
  if (phases > 0) return otsu(histogram_of(all), phases);
  const auto of_all = peaks_of(histogram_of(all)), of_inside = peaks_of(histogram_of(inside(gray, observed)));
  return of_inside.size() > of_all.size() ? of_inside : of_all;
}

}  // namespace terrazzo::media
