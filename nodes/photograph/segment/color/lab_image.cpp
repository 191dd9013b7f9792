#include "nodes/photograph/segment/color/lab_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

constexpr std::size_t kRows = 16;  // rows per task

template <class Row>
void each_row(const LabImage& image, const Work& work, Row&& row) {
  work.parallel(image.height, kRows, [&](std::size_t b, std::size_t e) {
    for (std::size_t y = b; y < e; ++y) row(static_cast<int>(y));
  });
}

int mirrored(int i, int n) {
  if (n == 1) return 0;
  while (i < 0 || i >= n) i = i < 0 ? -i - 1 : 2 * n - 1 - i;
  return i;
}

}  // namespace

LabImage lab_section(const Image& image, int section, const Work& work) {
  LabImage lab{image.width, image.height, {}};
  lab.pixels.resize(pixels_in(image.width, image.height));
  const Vec3f* first = image.pixels.data() + image.index(0, 0, section);
  each_row(lab, work, [&](int y) {
    for (std::size_t i = lab.index(0, y); i < lab.index(0, y + 1); ++i)
      lab.pixels[i] = linear_to_oklab(first[i]);
  });
  return lab;
}

float noise_of(const LabImage& image) {
  std::vector<float> response;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      auto L = [&](int dx, int dy) { return image.pixels[image.index(x + dx, y + dy)][0]; };
      response.push_back(std::abs(L(-1, -1) - 2 * L(0, -1) + L(1, -1) - 2 * L(-1, 0) + 4 * L(0, 0) -
                                  2 * L(1, 0) + L(-1, 1) - 2 * L(0, 1) + L(1, 1)));
    }
  if (response.empty()) return 0;
  return median(std::move(response)) / (6 * 0.6745f);
}

LabImage diffuse(LabImage image, float contrast, int rounds, const Work& work) {
  LabImage next = image;
  const float scale = 1 / (contrast * contrast);
  for (int round = 0; round < rounds; ++round) {
    each_row(image, work, [&](int y) {
      for (int x = 0; x < image.width; ++x) {
        const std::size_t i = image.index(x, y);
        const Vec3f& c = image.pixels[i];
        Vec3f sum = Vec3f::Zero();
        auto add = [&](std::size_t j) {
          const Vec3f d = image.pixels[j] - c;
          sum += d / (1 + d.squaredNorm() * scale);
        };
        if (x > 0) add(i - 1);
        if (x + 1 < image.width) add(i + 1);
        if (y > 0) add(i - image.width);
        if (y + 1 < image.height) add(i + image.width);
        next.pixels[i] = c + 0.2f * sum;
      }
    });
    std::swap(image, next);
  }
  return image;
}

LabImage median3(const LabImage& image, const Work& work) {
  LabImage out = image;
  each_row(image, work, [&](int y) {
    float v[9];
    for (int x = 0; x < image.width; ++x)
      for (int k = 0; k < 3; ++k) {
        int n = 0;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx)
            v[n++] =
                image.pixels[image.index(mirrored(x + dx, image.width), mirrored(y + dy, image.height))][k];
        std::nth_element(v, v + 4, v + 9);
        out.pixels[out.index(x, y)][k] = v[4];
      }
  });
  return out;
}

void blur_in_place(const cv::Mat& image, float sigma, const Work& work) {
  if (sigma <= 0) return;
  const int size = 2 * round_up(3 * sigma) + 1;
  const cv::Mat kernel = cv::getGaussianKernel(size, sigma, CV_32F);
  const cv::Mat from = image.clone();
  // Each strip also filters the rows around it, so strips should be tall.
  work.parallel(image.rows, std::max<std::size_t>(kRows, 4 * size), [&](std::size_t b, std::size_t e) {
    const cv::Range part(static_cast<int>(b), static_cast<int>(e));
    cv::Mat strip = image.rowRange(part);
    cv::sepFilter2D(from.rowRange(part), strip, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REFLECT);
  });
}

LabImage blur(LabImage image, float sigma, const Work& work) {
  blur_in_place(cv::Mat(image.height, image.width, CV_32FC3, image.pixels.data()), sigma, work);
  return image;
}

}  // namespace terrazzo::segment
