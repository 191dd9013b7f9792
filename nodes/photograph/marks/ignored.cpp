#include "nodes/photograph/marks/ignored.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "graph/text/read_number.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/data/equal_size.h"
#include "nodes/data/indices.h"

namespace terrazzo::segment {

Area read_area(const std::string& text) {
  const std::vector<double> v = read_numbers(text).value_or(std::vector<double>());
  const bool possible = std::all_of(v.begin(), v.end(), [](double x) { return std::abs(x) <= 1e9; });
  if (!possible || v.size() < 4 || v.size() % 2 != 0)
    throw Error("bad-region", "'" + text + "' is not an area",
                "write four numbers, x0 y0 x1 y1, for a rectangle, or the x and y of three or more corners "
                "of a polygon, "
                "in pixels from the upper left corner")
        .parameter("ignore");
  if (v.size() == 4) return {{v[0], v[1]}, {v[2], v[1]}, {v[2], v[3]}, {v[0], v[3]}};
  Area area;
  for (std::size_t k = 0; k < v.size(); k += 2) area.emplace_back(v[k], v[k + 1]);
  return area;
}

IgnoredPixels ignored_pixels(const Image& image, const std::vector<Area>& areas, const Labels* mask) {
  if (mask)
    require_equal_size(*mask, "the mask has", image, "the image has", "connect a mask of the same image");
  if (areas.empty() && !mask) return {};
  IgnoredPixels out(image.pixels.size(), 0);
  const std::size_t size = pixels_in(image.width, image.height);
  for (const Area& area : areas)
    for (const auto i : surrounded(image.width, image.height, {area})) out[i] = 1;
  for (int s = 1; s < image.sections; ++s) std::copy_n(out.begin(), size, out.begin() + (size * s));
  if (mask)
    for (std::size_t i = 0; i < out.size(); ++i) out[i] |= mask->ids[i] != 0;
  const auto ignored = std::count(out.begin(), out.end(), 1);
  if (ignored == static_cast<std::ptrdiff_t>(out.size()))
    throw Error("empty-image", "every pixel of the image is ignored", "make the ignored areas smaller")
        .parameter("ignore");
  if (ignored == 0) out.clear();
  return out;
}

void cover_ignored(Image& image, int section, const IgnoredPixels& ignored) {
  if (ignored.empty()) return;
  const std::size_t first = image.index(0, 0, section);
  const cv::Mat mask(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(ignored.data() + first));
  // Every pixel learns the number of its nearest zero pixel.
  cv::Mat distance, nearest;
  cv::distanceTransform(mask, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<cv::Point> place(mask.total() + 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (mask.at<std::uint8_t>(y, x) == 0) place[nearest.at<int>(y, x)] = {x, y};
  const cv::Rect whole({0, 0}, mask.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (mask.at<std::uint8_t>(y, x) == 0) continue;
      const cv::Point edge = place[nearest.at<int>(y, x)];
      // Less far behind the edge where the picture ends or is ignored too; the edge itself is seen.
      cv::Point behind = edge - cv::Point(x, y);
      while (!whole.contains(edge + behind) || mask.at<std::uint8_t>(edge + behind) != 0) behind /= 2;
      image.at(x, y, section) = image.at(edge.x + behind.x, edge.y + behind.y, section);
    }
}

Positions::Positions(const std::uint8_t* ignored, int width, int height)
    : width_(width), height_(height), sums_(static_cast<std::size_t>(width + 1) * (height + 1), 0) {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y + 1) * (width + 1) + x + 1;
      sums_[i] = sums_[i - 1] + sums_[i - width - 1] - sums_[i - width - 2] + ignored[pixel_at(x, y, width)];
    }
}

bool Positions::contains(int left, int top, int w, int h) const {
  if (left < 1 || top < 1 || left + w >= width_ || top + h >= height_) return false;
  const std::size_t row = static_cast<std::size_t>(width_) + 1;
  const std::int32_t *above = &sums_[(top - 1) * row + left - 1],
                     *below = &sums_[(top + h + 1) * row + left - 1];
  return below[w + 2] - below[0] - above[w + 2] + above[0] == 0;
}

std::int64_t Positions::count(int w, int h) const {
  std::int64_t n = 0;
  const std::size_t row = static_cast<std::size_t>(width_) + 1;
  for (int y = 0; y + h + 2 <= height_; ++y) {
    const std::int32_t *top = &sums_[y * row], *bottom = &sums_[(y + h + 2) * row];
    for (int x = 0; x + w + 2 <= width_; ++x)
      n += bottom[x + w + 2] - bottom[x] - top[x + w + 2] + top[x] == 0;
  }
  return n;
}

}  // namespace terrazzo::segment
