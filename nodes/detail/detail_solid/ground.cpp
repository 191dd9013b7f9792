#include "nodes/detail/detail_solid/ground.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/luminance.h"
#include "nodes/detail/detail_solid/fill.h"
#include "nodes/detail/detail_solid/shadows.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kGroundSide = 512;    // pixels
constexpr double kLeastSoil = 0.1;  // of the window
constexpr double kFromOutline = 2;  // pixels from outlines that the camera mixes with stones
constexpr int kSeam = 48;           // pixels in which the soil goes over into that of the opposite edge
constexpr int kTones = 101;
constexpr int kIgnored = 1;  // in Segment's output unobserved

// 1 where a section shows soil, away from outlines.
cv::Mat soil_of(const Labels& labels, const Labels* mask, int section) {
  cv::Mat soil(labels.height, labels.width, CV_8U);
  for (int y = 0; y < labels.height; ++y)
    for (int x = 0; x < labels.width; ++x) {
      const std::size_t i = labels.index(x, y, section);
      soil.at<std::uint8_t>(y, x) = labels.ids[i] == 0 && (mask == nullptr || mask->ids[i] == 0);
    }
  cv::Mat depth;
  cv::distanceTransform(soil, depth, cv::DIST_L2, cv::DIST_MASK_5);
  return depth > kFromOutline;
}

// Leaves out shadows of stones, which View casts anew: places that reach an outline and are darker than most
// soil by more than a standard deviation. `shade`: logarithm of the luminance.
void leave_out_shadows(cv::Mat& soil, const cv::Mat& shade) {
  constexpr double kGrain = 2;  // pixels, blurred so that single grains don't count
  cv::Mat weight, even;
  soil.convertTo(weight, CV_32F, 1.0 / 255);
  cv::GaussianBlur(shade.mul(weight), even, {0, 0}, kGrain);
  cv::GaussianBlur(weight, weight, {0, 0}, kGrain);
  even /= cv::max(weight, 1e-6F);
  std::vector<float> values;
  for (std::size_t i = 0; i < soil.total(); ++i)
    if (soil.data[i]) values.push_back(even.ptr<float>()[i]);
  if (values.empty()) return;
  const float usual = median(values);
  for (float& v : values) v = std::abs(v - usual);
  const float dark = usual - kOfNormal * median(std::move(values));
  soil.setTo(0, outside_with_shadows(soil == 0, even < dark));
}

struct SoilWindow {
  int section = 0;
  cv::Rect area;
  int soil = 0;  // pixels
};

SoilWindow window_of_soil(const Labels& labels, const Labels* mask) {
  constexpr int kStep = 8;
  SoilWindow best;
  const cv::Size size(std::min(kGroundSide, labels.width), std::min(kGroundSide, labels.height));
  for (int section = 0; section < labels.sections; ++section) {
    cv::Mat sum;
    cv::integral(soil_of(labels, mask, section), sum, CV_64F);  // of 255 for each pixel of soil
    for (int y = 0; y + size.height <= labels.height; y += kStep)
      for (int x = 0; x + size.width <= labels.width; x += kStep) {
        const cv::Rect area(cv::Point(x, y), size);
        const double all = sum.at<double>(area.br()) - sum.at<double>(area.y, area.br().x) -
                           sum.at<double>(area.br().y, area.x) + sum.at<double>(area.tl());
        const int count = round_nearest(all / 255);
        if (count > best.soil) best = {section, area, count};
      }
  }
  return best;
}

// The window, as sRGB-encoded values, where it shows soil in the light.
PartialPicture soil_in(const SoilWindow& window, const Image& image, const Labels& labels,
                       const Labels* mask) {
  cv::Mat soil = soil_of(labels, mask, window.section)(window.area).clone();
  cv::Mat shade(soil.size(), CV_32F);
  for (int y = 0; y < soil.rows; ++y)
    for (int x = 0; x < soil.cols; ++x) {
      const Vec3f& color = image.at(window.area.x + x, window.area.y + y, window.section);
      shade.at<float>(y, x) = std::log(Detail::kSkinDark + std::max(0.0F, luminance_of(color)));
    }
  leave_out_shadows(soil, shade);  // of this window's soil, at least half stays
  PartialPicture picture;
  picture.width = window.area.width;
  picture.height = window.area.height;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const int u = window.area.x + x;
      const int v = window.area.y + y;
      picture.known.push_back(soil.at<std::uint8_t>(y, x) != 0);
      picture.value.push_back(linear_to_srgb(image.at(u, v, window.section).cwiseMax(0.0F)));
    }
  return picture;
}

// The columns at which to change over from the picture's right strip to its left one, by row: the path along
// which both differ least (Efros and Freeman 2001).
std::vector<int> best_cut(const PartialPicture& p, int strip) {
  const auto difference = [&](int x, int y) {
    return (p.value[pixel_at(x, y, p.width)] - p.value[pixel_at(p.width - strip + x, y, p.width)])
        .squaredNorm();
  };
  std::vector<float> sum(pixels_in(strip, p.height));
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < strip; ++x) {
      float before = y == 0 ? 0 : sum[pixel_at(x, y - 1, strip)];
      for (const int u : {x - 1, x + 1})
        if (y > 0 && u >= 0 && u < strip) before = std::min(before, sum[pixel_at(u, y - 1, strip)]);
      sum[pixel_at(x, y, strip)] = before + difference(x, y);
    }
  std::vector<int> path(p.height);
  for (int y = p.height - 1; y >= 0; --y) {
    const int from = y + 1 < p.height ? std::max(0, path[y + 1] - 1) : 0;
    const int to = y + 1 < p.height ? std::min(strip - 1, path[y + 1] + 1) : strip - 1;
    const auto row = sum.begin() + pixel_at(0, y, strip);
    path[y] = static_cast<int>(std::min_element(row + from, row + to + 1) - row);
  }
  return path;
}

// Narrower by a strip, and continues beyond its right edge at the left one.
PartialPicture joined_across(const PartialPicture& p) {
  const int strip = std::min(kSeam, p.width / 2);
  const std::vector<int> path = best_cut(p, strip);
  PartialPicture out;
  out.width = p.width - strip;
  out.height = p.height;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      out.value.push_back(p.value[pixel_at(x < path[y] ? out.width + x : x, y, p.width)]);
  return out;
}

PartialPicture transposed(const PartialPicture& p) {
  PartialPicture out;
  out.width = p.height;
  out.height = p.width;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) out.value.push_back(p.value[pixel_at(y, x, p.width)]);
  return out;
}

}  // namespace

Detail::Ground find_ground(const Image& image, const Labels& labels, const Labels* mask,
                           const Profiles& profiles, std::uint64_t seed, const Work& work) {
  if (profiles.view != View::Surface || shows_loose_stones(profiles)) return {};
  const SoilWindow window = window_of_soil(labels, mask);
  if (std::min(window.area.width, window.area.height) < kSeam || window.soil == 0 ||
      window.soil < kLeastSoil * window.area.area())
    return {};
  PartialPicture picture = soil_in(window, image, labels, mask);
  fill_picture(picture, seed, work);
  picture = transposed(joined_across(transposed(joined_across(picture))));
  Vec3 sum = Vec3::Zero();
  for (Vec3f& v : picture.value) {
    v = srgb_to_linear(v.cwiseMax(0.0F));
    sum += v.cast<double>();
  }
  const Vec3f mean = (sum / static_cast<double>(picture.value.size())).cast<float>();
  Detail::Ground ground;
  ground.width = picture.width;
  ground.height = picture.height;
  for (const Vec3f& v : picture.value) ground.shade.push_back(Detail::skin_shade(v, mean));
  return ground;
}

std::vector<float> find_tones(const Image& image, const Labels* mask, const Profiles& profiles) {
  if (profiles.view != View::Surface) return {};
  std::vector<float> all;
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    if (mask == nullptr || mask->ids[i] != kIgnored)
      all.push_back(luminance_of(image.pixels[i].cwiseMax(0.0F)));
  if (all.empty()) return {};
  std::sort(all.begin(), all.end());
  std::vector<float> tones;
  for (int k = 0; k < kTones; ++k) tones.push_back(all[(all.size() - 1) * k / (kTones - 1)]);
  return tones;
}

}  // namespace terrazzo::detail_solid
