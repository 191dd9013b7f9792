#include "nodes/detail/residual/picture_detail.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual/outline_depth.h"
#include "nodes/detail/residual/residual_field.h"

namespace terrazzo::residual {
namespace {

// Where a plane's pixels lie.
class PixelPoints {
 public:
  explicit PixelPoints(const PicturePlane& plane) : plane_(plane), normal_(plane.right.cross(plane.up)) {}
  Vec3f at(int x, int row) const {
    const double u = (x + 0.5) * plane_.mm_x, v = (plane_.height - row - 0.5) * plane_.mm_y;
    Vec3 point = plane_.origin + u * plane_.right + v * plane_.up;
    if (!plane_.above.empty()) point += double{plane_.above[pixel_at(x, row, plane_.width)]} * normal_;
    return point.cast<float>();
  }

 private:
  const PicturePlane& plane_;
  Vec3 normal_;
};

// Share of the binder's dark zone in each pixel, blurred as outlines are. Empty without zones.
std::vector<float> dark_zones(const PicturePlane& plane, std::span<const std::int32_t> ids,
                              const ResidualField& detail, const Work& work) {
  if (!detail.has_zones()) return {};
  const auto pixel = static_cast<float>(plane.mm_x);
  std::vector<float> dark =
      binder_width(ids.data(), plane.width, plane.height, plane.wrap, detail.pixel() / plane.mm_x, work);
  const PixelPoints points(plane);
  work.quiet().parallel(plane.height, 4, [&](std::size_t begin, std::size_t end) {
    for (int row = begin; row < static_cast<int>(end); ++row)
      for (int x = 0; x < plane.width; ++x) {
        float& width = dark[pixel_at(x, row, plane.width)];
        width = detail.dark_zone(points.at(x, row), width * pixel);
      }
  });
  if (const double sigma = detail.softness() / plane.mm_x; sigma > 0.2) {
    const int margin = round_up(4 * sigma);  // of the repeated picture, where edges join
    cv::Mat picture(plane.height, plane.width, CV_32F, dark.data()), wide;
    cv::copyMakeBorder(picture, wide, margin, margin, margin, margin,
                       plane.wrap ? cv::BORDER_WRAP : cv::BORDER_REPLICATE);
    cv::GaussianBlur(wide, wide, {0, 0}, sigma, sigma, cv::BORDER_REPLICATE);
    wide(cv::Rect(margin, margin, plane.width, plane.height)).copyTo(picture);
  }
  return dark;
}

}  // namespace

void add_to_picture(Vec3f* pixels, const PicturePlane& plane, std::span<const std::int32_t> ids,
                    std::span<const std::int32_t> owner, std::span<const float> cover,
                    const ResidualField& detail, const Work& work) {
  const Outlines outlines = nearest_outlines(ids.data(), plane.width, plane.height, plane.wrap);
  const std::vector<float> sizes = sizes_of_particles(ids, std::sqrt(plane.mm_x * plane.mm_y));
  const std::vector<float> dark = dark_zones(plane, ids, detail, work);
  const float pixel = plane.mm_x;
  const Vec3f right = plane.right.cast<float>(), up = plane.up.cast<float>();
  const PixelPoints points(plane);
  work.quiet().parallel(plane.height, 4, [&](std::size_t begin, std::size_t end) {
    for (int row = begin; row < static_cast<int>(end); ++row)
      for (int x = 0; x < plane.width; ++x) {
        const std::size_t at = pixel_at(x, row, plane.width);
        const Vec3f mm = points.at(x, row);
        const float share = std::min(cover[at], 1.0f), depth = outlines.depth[at] * pixel,
                    size = sizes[outlines.particle[at]], zone = dark.empty() ? -1 : dark[at];
        const Vec3f offset = detail.mixed(mm, owner[at], share, depth, size, nullptr, zone) +
                             detail.light(mm, owner[at], share, depth, size, outlines.normal[at], right, up);
        pixels[at] = srgb_to_linear((linear_to_srgb(pixels[at]) + offset).cwiseMax(0.0f));
      }
  });
}

}  // namespace terrazzo::residual
