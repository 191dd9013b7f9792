#include "nodes/detail/detail_solid/ground.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/luminance.h"
#include "nodes/detail/detail_solid/quilt.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kGroundSide = 512;    // pixels
constexpr double kLeastSoil = 0.1;  // of the window
constexpr double kFromOutline = 2;  // pixels from outlines that the camera mixes with stones
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

}  // namespace

Detail::Ground find_ground(const Image& image, const Labels& labels, const Labels* mask,
                           const Profiles& profiles, std::uint64_t seed, const Work& work) {
  if (profiles.view != View::Surface || shows_loose_stones(profiles)) return {};
  const SoilWindow window = window_of_soil(labels, mask);
  if (window.soil == 0 || window.soil < kLeastSoil * window.area.area()) return {};
  const cv::Mat soil = soil_of(labels, mask, window.section);
  PartialPicture picture;
  picture.width = window.area.width;
  picture.height = window.area.height;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const int u = window.area.x + x;
      const int v = window.area.y + y;
      const Vec3f& color = image.at(u, v, window.section);
      picture.known.push_back(soil.at<std::uint8_t>(v, u) != 0);
      picture.value.push_back(linear_to_srgb(color.cwiseMax(0.0F)));
    }
  picture = quilt_picture(picture, picture.width, picture.height, seed, work);
  if (picture.value.empty()) return {};
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
