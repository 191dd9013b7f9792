#include "nodes/detail/residual/camera_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "nodes/common/geometry/periodic.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::residual {
namespace {

constexpr std::uint64_t kStream = 0x6e6f6973;
constexpr int kReach = Detail::Noise::kReach, kSide = 2 * kReach + 1;
constexpr int kRows = 16;  // at a time

// Rows from `from` to `to` of white noise that is filtered with the kernel. `key`: of the picture and
// channel.
std::vector<float> filtered_rows(const std::vector<float>& kernel, int width, int height, int from, int to,
                                 bool wrap, std::uint64_t key) {
  const int around = width + 2 * kReach;
  std::vector<float> white(pixels_in(around, to - from + 2 * kReach));
  for (int y = 0; y < to - from + 2 * kReach; ++y)
    for (int x = 0; x < around; ++x) {
      int at_x = x - kReach, at_y = y + from - kReach;
      if (wrap) {
        at_x = wrap_index(at_x, width);
        at_y = wrap_index(at_y, height);
      }
      Random random(key, static_cast<std::uint64_t>(at_y + kReach),
                    static_cast<std::uint64_t>(at_x + kReach));
      white[pixel_at(x, y, around)] = random.normal();
    }
  std::vector<float> out(pixels_in(width, to - from), 0.0f);
  for (int y = 0; y < to - from; ++y) {
    float* row = &out[pixel_at(0, y, width)];
    for (int dy = 0; dy < kSide; ++dy)
      for (int dx = 0; dx < kSide; ++dx) {
        const float w = kernel[pixel_at(dx, dy, kSide)];
        const float* from_row = &white[pixel_at(dx, y + dy, around)];
        for (int x = 0; x < width; ++x) row[x] += w * from_row[x];
      }
  }
  return out;
}

// The deviation of means over squares of `edge` pixels of filtered noise; an edge below 1 counts as 1.
float share_of_means(const std::vector<float>& kernel, double edge) {
  if (!(edge > 1)) return 1;
  const auto at = [&](int x, int y) {
    return x < 0 || y < 0 || x >= kSide || y >= kSide ? 0.0 : double{kernel[pixel_at(x, y, kSide)]};
  };
  double variance = 0;
  for (int dy = 1 - kSide; dy < kSide; ++dy)
    for (int dx = 1 - kSide; dx < kSide; ++dx) {
      const double both = std::max(0.0, 1 - std::abs(dx) / edge) * std::max(0.0, 1 - std::abs(dy) / edge);
      if (!(both > 0)) continue;
      double covariance = 0;
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) covariance += at(x, y) * at(x + dx, y + dy);
      variance += both * covariance;
    }
  return std::sqrt(std::max(0.0, variance)) / edge;
}

}  // namespace

const Eigen::Matrix3f& noise_axes() {
  static const Eigen::Matrix3f axes = [] {
    Eigen::Matrix3f m;
    m.row(0) = Vec3f(1, 1, 1).normalized();
    m.row(1) = Vec3f(1, 0, -1).normalized();
    m.row(2) = Vec3f(1, -2, 1).normalized();
    return m;
  }();
  return axes;
}

float deviation_at(const std::vector<float>& deviations, float lightness) {
  const float n = deviations.size();
  return Detail::at_distance(deviations, lightness * n);
}

Camera camera_of(const Detail& detail, std::uint64_t seed) {
  return {detail.softness * detail.pixel_size, &detail.noise, detail.pixel_size, seed};
}

void add_noise(Vec3f* pixels, int width, int height, double pixel, bool wrap, const Camera& camera,
               std::uint64_t picture, const Work& work) {
  const Detail::Noise* noise = camera.noise;
  if (!noise || noise->gray.empty()) return;
  const double edge = pixel / camera.noise_pixel;
  const float share = share_of_means(noise->gray_kernel, edge),
              chroma_share = noise->chroma.empty() ? 0 : share_of_means(noise->chroma_kernel, edge);
  const Vec3f red = noise_axes().row(1), green = noise_axes().row(2);
  const std::uint64_t key = mix64(camera.seed ^ kStream) + 3 * picture;
  work.quiet().parallel((height + kRows - 1) / kRows, 1, [&](std::size_t band, std::size_t) {
    const int from = band * kRows, to = std::min(height, from + kRows);
    const auto rows = [&](const std::vector<float>& kernel, std::uint64_t channel) {
      return filtered_rows(kernel, width, height, from, to, wrap, key + channel);
    };
    const std::vector<float> gray = rows(noise->gray_kernel, 0);
    std::vector<float> chroma[2];
    if (!noise->chroma.empty())
      for (std::uint64_t c = 0; c < 2; ++c) chroma[c] = rows(noise->chroma_kernel, c + 1);
    for (std::size_t i = 0; i < gray.size(); ++i) {
      Vec3f& v = pixels[pixel_at(0, from, width) + i];
      Vec3f encoded = linear_to_srgb(v);
      const float light = encoded.mean();
      encoded.array() += share * deviation_at(noise->gray, light) * gray[i];
      if (!noise->chroma.empty())
        encoded +=
            chroma_share * deviation_at(noise->chroma, light) * (chroma[0][i] * red + chroma[1][i] * green);
      v = srgb_to_linear(encoded.cwiseMax(0.0f));
    }
  });
}

}  // namespace terrazzo::residual
