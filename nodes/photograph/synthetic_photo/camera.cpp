#include "nodes/photograph/synthetic_photo/camera.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::synthetic_photo {
namespace {

cv::Mat view(Picture& p) { return {p.height, p.width, CV_32FC3, p.pixels.data()}; }

// What JPEG does to the pixels: 8 × 8 cosine transforms of brightness and halved chroma, rounded to the
// standard's table (ITU-T T.81, annex K) at this quality.
void compress(Picture& p, int quality) {
  static const int table[64] = {16, 11, 10, 16, 24,  40,  51,  61,  12, 12, 14, 19, 26,  58,  60,  55,
                                14, 13, 16, 24, 40,  57,  69,  56,  14, 17, 22, 29, 51,  87,  80,  62,
                                18, 22, 37, 56, 68,  109, 103, 77,  24, 35, 55, 64, 81,  104, 113, 92,
                                49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99};
  const double scale = quality < 50 ? 50.0 / quality : 2 - quality / 50.0;
  cv::Mat all, channels[3];
  cv::cvtColor(view(p), all, cv::COLOR_RGB2YCrCb);
  cv::split(all, channels);
  for (int c = 0; c < 3; ++c) {
    cv::Mat m = channels[c] * 255, padded;
    if (c > 0)
      cv::resize(m, m, cv::Size(std::max(1, p.width / 2), std::max(1, p.height / 2)), 0, 0, cv::INTER_AREA);
    const cv::Size size = m.size();
    cv::copyMakeBorder(m, padded, 0, (8 - size.height % 8) % 8, 0, (8 - size.width % 8) % 8,
                       cv::BORDER_REPLICATE);
    for (int y = 0; y < padded.rows; y += 8)
      for (int x = 0; x < padded.cols; x += 8) {
        cv::Mat block = padded(cv::Rect(x, y, 8, 8)), f;
        cv::dct(block, f);
        for (int k = 0; k < 64; ++k) {
          const float q = std::max(1.0, scale * table[k] * (c > 0 ? 1.4 : 1));
          float& v = f.at<float>(k / 8, k % 8);
          v = std::round(v / q) * q;
        }
        cv::idct(f, block);
      }
    m = padded(cv::Rect(0, 0, size.width, size.height));
    cv::resize(m, channels[c], cv::Size(p.width, p.height), 0, 0, cv::INTER_LINEAR);
    channels[c] /= 255;
  }
  cv::merge(channels, 3, all);
  cv::Mat rgb;
  cv::cvtColor(all, rgb, cv::COLOR_YCrCb2RGB);
  rgb.copyTo(view(p));
}

}  // namespace

Picture expose(const Canvas& c, const std::vector<Vec3f>& radiance, bool gray, Random& r) {
  std::vector<float> bright;
  for (const auto& v : radiance) bright.push_back(v.sum() / 3);
  const float high = at_rank(bright, static_cast<std::size_t>(bright.size() * 0.9));
  const double gain = r.uniform(0.3, 0.95) / std::max(0.01f, high);
  Vec3f balance = Vec3f::Ones();
  const double cast = r.uniform(0, 0.12);
  if (!gray)
    balance = Vec3f(static_cast<float>(1 + cast * r.normal()), 1, static_cast<float>(1 + cast * r.normal()))
                  .cwiseMax(0.6f);
  const double slope_x = r.uniform() < 0.5 ? 0.35 * r.normal() : 0,
               slope_y = r.uniform() < 0.5 ? 0.35 * r.normal() : 0;
  const double vignette = r.uniform() < 0.3 ? r.uniform(0, 0.5) : 0;
  std::vector<Vec3f> light = radiance;
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const double u = 2.0 * x / c.width - 1, v = 2.0 * y / c.height - 1;
      const double uneven =
          std::exp(0.5 * (slope_x * u + slope_y * v)) * (1 - vignette * (u * u + v * v) / 2);
      light[c.at(x, y)] = (balance * static_cast<float>(gain * uneven)).cwiseProduct(light[c.at(x, y)]);
    }
  cv::Mat m(c.height, c.width, CV_32FC3, light.data());
  if (const double sigma = r.uniform() < 0.25 ? r.uniform(0, 4) : r.uniform(0, 1.6); sigma > 0.3)
    cv::GaussianBlur(m, m, cv::Size(0, 0), sigma, sigma, cv::BORDER_REPLICATE);
  Picture p;
  p.width = c.width / 2;
  p.height = c.height / 2;
  p.pixels.resize(pixels_in(p.width, p.height));
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const Vec3f sum = light[c.at(2 * x, 2 * y)] + light[c.at(2 * x + 1, 2 * y)] +
                        light[c.at(2 * x, 2 * y + 1)] + light[c.at(2 * x + 1, 2 * y + 1)];
      p.pixels[pixel_at(x, y, p.width)] = linear_to_srgb((sum / 4).cwiseMax(0.0f).cwiseMin(1.0f));
    }
  return p;
}

void develop(Picture& p, bool gray, Random& r) {
  if (gray)
    for (auto& v : p.pixels) v.setConstant(v.sum() / 3);
  cv::Mat m = view(p), other;
  if (r.uniform() < 0.25) {  // enlarged or reduced on the way
    const double f = r.uniform(0.5, 0.95);
    cv::resize(m, other, cv::Size(), f, f, cv::INTER_AREA);
    cv::resize(other, m, m.size(), 0, 0, r.uniform() < 0.5 ? cv::INTER_LINEAR : cv::INTER_CUBIC);
  }
  const double noise = r.uniform() < 0.3 ? 0 : r.uniform() * r.uniform(0.005, gray ? 0.09 : 0.05);
  const bool colored = !gray && r.uniform() < 0.5;
  if (noise > 0)
    for (auto& v : p.pixels) {
      const double common = noise * r.normal();
      for (int k = 0; k < 3; ++k) v[k] += static_cast<float>(colored ? noise * r.normal() : common);
    }
  if (r.uniform() < 0.4) {  // a telephone's noise reduction smears texture and keeps edges
    cv::bilateralFilter(m, other, 7, r.uniform(0.02, 0.2), r.uniform(1, 4));
    other.copyTo(m);
  } else if (r.uniform() < 0.15) {
    cv::medianBlur(m, other, r.uniform() < 0.6 ? 3 : 5);
    other.copyTo(m);
  }
  if (!gray && r.uniform() < 0.25) {  // dull colors
    const float keep = r.uniform(0.4, 0.95);
    for (auto& v : p.pixels) v = Vec3f::Constant(v.sum() / 3) * (1 - keep) + v * keep;
  }
  if (r.uniform() < 0.35) {
    cv::GaussianBlur(m, other, cv::Size(0, 0), r.uniform(0.6, 1.5));
    const double amount = r.uniform(0.2, 1.2);
    cv::addWeighted(m, 1 + amount, other, -amount, 0, m);
  }
  const double contrast = r.uniform() < 0.3 ? r.uniform(0.4, 0.8) : r.uniform(0.75, 1.25),
               gamma = std::exp(0.2 * r.normal());
  for (auto& v : p.pixels)
    for (int k = 0; k < 3; ++k) v[k] = std::pow(std::clamp(0.5 + contrast * (v[k] - 0.5), 0.0, 1.0), gamma);
  if (r.uniform() < 0.6) compress(p, 30 + static_cast<int>(r.below(66)));
  for (auto& v : p.pixels)
    for (int k = 0; k < 3; ++k) v[k] = std::round(std::clamp(v[k], 0.0f, 1.0f) * 255) / 255;
}

}  // namespace terrazzo::synthetic_photo
