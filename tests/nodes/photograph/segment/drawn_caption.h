// Captions and rulers drawn into pictures, and the losses of JPEG.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "nodes/common/plot/drawing.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"

namespace terrazzo::test {

inline Vec3f gray_level(int level) {
  return srgb_to_linear(Vec3f::Constant(static_cast<float>(level) / 255.0f));
}

// The picture with a strip of `height` rows below it, which has two texts and a scale bar.
inline Image with_strip(const Image& picture, int height, const Vec3f& paper, const Vec3f& ink) {
  Image out(picture.width, picture.height + height, 1, picture.pixel_size, paper);
  std::copy(picture.pixels.begin(), picture.pixels.end(), out.pixels.begin());
  Coverage text(out.width, out.height);
  const double h = height, y = picture.height;
  add_text(text, 0.02 * out.width, y + 0.2 * h, "15.0 kV  WD 12.1 mm", 0.5 * h);
  add_text(text, 0.75 * out.width, y + 0.05 * h, "100 um", 0.45 * h);
  text.rectangle(std::round(0.7 * out.width), y + std::round(0.7 * h), std::round(0.95 * out.width),
                 y + std::round(0.82 * h));
  text.paint(out, ink);
  return out;
}

// Quarter turns clockwise.
inline Image turned(const Image& image, int quarters) {
  Image out = image;
  for (int k = 0; k < quarters; ++k) {
    Image next(out.height, out.width, 1, image.pixel_size);
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) next.at(out.height - 1 - y, x) = out.at(x, y);
    out = std::move(next);
  }
  return out;
}

// What JPEG keeps of the light: cosines of 8 × 8 pixels, rounded to multiples of `loss` levels and more at
// high frequencies.
inline Image compressed(const Image& image, float loss) {
  Image out = image;
  for (int top = 0; top < image.height; top += 8)
    for (int left = 0; left < image.width; left += 8) {
      cv::Mat block(8, 8, CV_32F);
      const auto at = [&](int x, int y) -> Vec3f& {
        return out.at(std::min(left + x, image.width - 1), std::min(top + y, image.height - 1));
      };
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) block.at<float>(y, x) = 255 * linear_to_srgb(at(x, y))[0];
      cv::dct(block, block);
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
          const float step = loss * static_cast<float>(1 + x + y);
          block.at<float>(y, x) = step * std::round(block.at<float>(y, x) / step);
        }
      cv::idct(block, block);
      for (int y = 0; y < std::min(8, image.height - top); ++y)
        for (int x = 0; x < std::min(8, image.width - left); ++x)
          at(x, y) = gray_level(std::clamp(static_cast<int>(std::lround(block.at<float>(y, x))), 0, 255));
    }
  return out;
}

}  // namespace terrazzo::test
