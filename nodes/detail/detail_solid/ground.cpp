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
    const cv::Mat soil = soil_of(labels, mask, section);
    for (int y = 0; y + size.height <= labels.height; y += kStep)
      for (int x = 0; x + size.width <= labels.width; x += kStep) {
        const cv::Rect area(cv::Point(x, y), size);
        const int count = cv::countNonZero(soil(area));
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
  if (window.soil < kLeastSoil * window.area.area()) return {};
  const cv::Mat soil = soil_of(labels, mask, window.section);
  PartialPicture picture;
  picture.width = window.area.width;
  picture.height = window.area.height;
  Vec3 sum = Vec3::Zero();
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const int u = window.area.x + x;
      const int v = window.area.y + y;
      const Vec3f& color = image.at(u, v, window.section);
      picture.known.push_back(soil.at<std::uint8_t>(v, u) != 0);
      picture.value.push_back(linear_to_srgb(color.cwiseMax(0.0F)));
      if (picture.known.back() != 0) sum += color.cast<double>();
    }
  const Vec3f mean = (sum / window.soil).cast<float>();
  picture = quilt_picture(picture, picture.width, picture.height, seed, work);
  Detail::Ground ground;
  ground.width = picture.width;
  ground.height = picture.height;
  for (const Vec3f& v : picture.value)
    ground.shade.push_back(Detail::skin_shade(srgb_to_linear(v.cwiseMax(0.0F)), mean));
  return ground;
}

std::vector<float> find_tones(const Image& image, const Profiles& profiles) {
  if (profiles.view != View::Surface) return {};
  std::vector<float> all;
  for (const Vec3f& color : image.pixels) all.push_back(luminance_of(color.cwiseMax(0.0F)));
  std::sort(all.begin(), all.end());
  std::vector<float> tones;
  for (int k = 0; k < kTones; ++k) tones.push_back(all[(all.size() - 1) * k / (kTones - 1)]);
  return tones;
}

}  // namespace terrazzo::detail_solid
