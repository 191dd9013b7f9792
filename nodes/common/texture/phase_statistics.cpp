#include "nodes/common/texture/phase_statistics.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace terrazzo {
namespace {

// Visits the lines of an image along x and along y: first pixel, number of pixels, step between them.
template <class Use>
void each_line(int width, int height, Use&& use) {
  for (int y = 0; y < height; ++y) use(static_cast<std::ptrdiff_t>(y) * width, width, 1);
  for (int x = 0; x < width; ++x) use(x, height, width);
}

std::vector<double> ratios(const std::vector<double>& part, const std::vector<double>& whole) {
  std::vector<double> out;
  for (std::size_t k = 0; k < part.size(); ++k) out.push_back(whole[k] > 0 ? part[k] / whole[k] : 0);
  return out;
}

}  // namespace

PhaseStatistics phase_statistics(const std::vector<Phase>& pictures, int reach) {
  const auto n = static_cast<std::size_t>(reach) + 1;
  std::vector<double> both(n, 0), whole(n, 0), pairs(n, 0), segments(n, 0);
  const auto line = [&](const std::uint8_t* first, int length, int stride) {
    int run = 0, observed = 0;
    for (int i = 0; i < length; ++i) {
      const std::uint8_t* p = first + static_cast<std::ptrdiff_t>(i) * stride;
      run = *p == 1 ? run + 1 : 0;
      observed = *p < 2 ? observed + 1 : 0;
      if (*p == 2) continue;
      // Segments that end at this pixel.
      for (int r = 0; r <= std::min(i, reach); ++r) {
        const std::size_t k = r;
        const std::uint8_t other = p[-static_cast<std::ptrdiff_t>(r) * stride];
        pairs[k] += other < 2;
        segments[k] += observed > r;
        both[k] += *p == 1 && other == 1;
        whole[k] += run > r;
      }
    }
  };
  for (const Phase& p : pictures)
    each_line(p.width, p.height,
              [&](std::ptrdiff_t first, int length, int stride) { line(&p.in[first], length, stride); });
  return {ratios(both, pairs), ratios(whole, segments)};
}

std::vector<double> cluster_function(const std::vector<Phase>& pictures, int reach) {
  const auto n = static_cast<std::size_t>(reach) + 1;
  std::vector<double> both(n, 0), pairs(n, 0);
  for (const Phase& p : pictures) {
    cv::Mat1b in(p.height, p.width);
    std::transform(p.in.begin(), p.in.end(), in.begin(), [](std::uint8_t v) { return v == 1; });
    cv::Mat1i pieces;
    cv::connectedComponents(in, pieces, 4);
    each_line(p.width, p.height, [&](std::ptrdiff_t first, int length, int stride) {
      for (int i = 0; i < length; ++i) {
        const std::ptrdiff_t end = first + static_cast<std::ptrdiff_t>(i) * stride;
        if (p.in[end] == 2) continue;
        const int piece = pieces(static_cast<int>(end / p.width), static_cast<int>(end % p.width));
        for (int r = 0; r <= std::min(i, reach); ++r) {
          const std::ptrdiff_t start = end - static_cast<std::ptrdiff_t>(r) * stride;
          pairs[r] += p.in[start] < 2;
          both[r] += piece > 0 &&
                     piece == pieces(static_cast<int>(start / p.width), static_cast<int>(start % p.width));
        }
      }
    });
  }
  return ratios(both, pairs);
}

}  // namespace terrazzo
