#include "nodes/bodies/contact_sheet/resize.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::contact_sheet {

namespace {

double lanczos3(double x) {
  x = std::abs(x);
  if (x >= 3) return 0;
  if (x < 1e-9) return 1;
  const double p = M_PI * x;
  return 3 * std::sin(p) * std::sin(p / 3) / (p * p);
}

double catmull_rom(double x) {
  x = std::abs(x);
  if (x >= 2) return 0;
  return x < 1 ? 1 + x * x * (1.5 * x - 2.5) : 2 + x * (-4 + x * (2.5 - 0.5 * x));
}

struct Taps {
  int first = 0;
  std::vector<float> weights;
};

// Filter weights of every output pixel along one axis. Edge pixels repeat beyond the border.
std::vector<Taps> taps_of(int from, int to) {
  const double ratio = static_cast<double>(from) / to, stretch = std::max(1.0, ratio),
               reach = (ratio > 1 ? 3 : 2) * stretch;
  std::vector<Taps> taps(to);
  for (int i = 0; i < to; ++i) {
    const double center = (i + 0.5) * ratio - 0.5;
    const int lo = round_up(center - reach), hi = round_down(center + reach);
    taps[i].first = std::clamp(lo, 0, from - 1);
    taps[i].weights.assign(std::clamp(hi, 0, from - 1) - taps[i].first + 1, 0.0f);
    double sum = 0;
    for (int k = lo; k <= hi; ++k)
      sum += ratio > 1 ? lanczos3((k - center) / stretch) : catmull_rom(k - center);
    for (int k = lo; k <= hi; ++k) {
      const double w = ratio > 1 ? lanczos3((k - center) / stretch) : catmull_rom(k - center);
      taps[i].weights[std::clamp(k, 0, from - 1) - taps[i].first] += static_cast<float>(w / sum);
    }
  }
  return taps;
}

}  // namespace

Image resized(const Image& image, int section, int width, int height, const Work& work) {
  const bool larger = width > image.width;
  const auto across = taps_of(image.width, width), down = taps_of(image.height, height);
  Image narrow(width, image.height, 1, image.pixel_size * image.width / width),
      out(width, height, 1, narrow.pixel_size);
  work.parallel(image.height, 16, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3f> row(image.width);
    for (int y = begin; y < static_cast<int>(end); ++y) {
      for (int x = 0; x < image.width; ++x) {
        const Vec3f c = image.at(x, y, section).cwiseMax(0.0f);
        row[x] = larger ? linear_to_srgb(c) : c;
      }
      for (int x = 0; x < width; ++x) {
        Vec3f sum = Vec3f::Zero();
        for (std::size_t k = 0; k < across[x].weights.size(); ++k)
          sum += across[x].weights[k] * row[across[x].first + k];
        narrow.at(x, y) = sum;
      }
    }
  });
  work.parallel(height, 16, [&](std::size_t begin, std::size_t end) {
    for (int y = begin; y < static_cast<int>(end); ++y)
      for (int x = 0; x < width; ++x) {
        Vec3f sum = Vec3f::Zero();
        for (std::size_t k = 0; k < down[y].weights.size(); ++k)
          sum += down[y].weights[k] * narrow.at(x, down[y].first + static_cast<int>(k));
        out.at(x, y) = larger ? srgb_to_linear(sum.cwiseMax(0.0f)) : Vec3f(sum.cwiseMax(0.0f));
      }
  });
  return out;
}

}  // namespace terrazzo::contact_sheet
