#include "nodes/photograph/marks/objects.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/components.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/marks/captions.h"
#include "nodes/photograph/marks/levels.h"
#include "nodes/photograph/marks/scales.h"

namespace terrazzo::segment {
namespace {

struct Marked {
  FoundObject::Kind kind;
  std::vector<cv::Point> corners;  // of a convex polygon
};

std::vector<Marked> marked_objects(const Image& image, int section, const Work& work) {
  const cv::Mat levels = levels_of(image, section);
  std::vector<Marked> all;
  const std::vector<cv::Rect> captions = find_captions(levels);
  for (const cv::Rect& r : captions)
    all.push_back({FoundObject::Kind::Caption,
                   {{r.x, r.y}, {r.br().x - 1, r.y}, {r.br().x - 1, r.br().y - 1}, {r.x, r.br().y - 1}}});
  for (const auto& corners : find_scales(levels, captions, work))
    all.push_back({FoundObject::Kind::Ruler, corners});
  return all;
}

// Marks what is not 0 in `mask`, of the section's size, and returns the object.
FoundObject ignore(const cv::Mat& mask, FoundObject::Kind kind, int section, const Image& image,
                   IgnoredPixels& ignored) {
  const cv::Rect box = cv::boundingRect(mask);
  ignored.resize(image.pixels.size(), 0);
  for (int y = box.y; y < box.br().y; ++y)
    for (int x = box.x; x < box.br().x; ++x)
      if (mask.at<std::uint8_t>(y, x)) ignored[image.index(x, y, section)] = 1;
  return {kind, section, box.x, box.y, box.br().x - 1, box.br().y - 1, cv::countNonZero(mask)};
}

// The hull of an object if it fills most of that.
cv::Mat filled(const cv::Mat& mask) {
  constexpr double kMost = 0.65;
  std::vector<cv::Point> pixels, hull;
  cv::findNonZero(mask, pixels);
  cv::convexHull(pixels, hull);
  cv::Mat whole(mask.size(), CV_8U, cv::Scalar(0));
  cv::fillConvexPoly(whole, hull, cv::Scalar(255));
  return pixels.size() >= kMost * cv::countNonZero(whole) ? whole : mask;
}

}  // namespace

std::vector<FoundObject> find_objects(const Image& image, IgnoredPixels& ignored, const Work& work) {
  std::vector<std::vector<Marked>> of_section(image.sections);
  work.parallel(of_section.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) of_section[s] = marked_objects(image, s, work.quiet());
  });
  std::vector<FoundObject> objects;
  for (int s = 0; s < image.sections; ++s)
    for (const Marked& m : of_section[s]) {
      cv::Mat mask(image.height, image.width, CV_8U, cv::Scalar(0));
      cv::fillConvexPoly(mask, m.corners, cv::Scalar(255));
      objects.push_back(ignore(mask, m.kind, s, image, ignored));
    }
  if (!objects.empty() && std::find(ignored.begin(), ignored.end(), 0) == ignored.end())
    throw Error("empty-image", "every pixel of the image shows a caption or a ruler, or is ignored",
                "set find_objects to false")
        .parameter("find_objects");
  return objects;
}

void add_objects_of_network(const std::vector<float>& not_material, int section, const Image& image,
                            IgnoredPixels& ignored, std::vector<FoundObject>& objects) {
  constexpr double kSure = 0.85;
  const std::size_t first = image.index(0, 0, section);
  std::vector<std::int32_t> found;
  for (std::size_t i = 0; i < not_material.size(); ++i)
    found.push_back(not_material[i] > 0.5f && (ignored.empty() || !ignored[first + i]));
  const Components parts = connected_components(found, image.width, image.height, true);
  std::vector<double> certainty(parts.count(), 0);
  for (std::size_t i = 0; i < found.size(); ++i)
    if (const auto k = parts.ids[i]; k > 0)
      certainty[k - 1] += not_material[i] / static_cast<double>(parts.sizes[k - 1]);
  const auto smallest =
      std::max<std::int64_t>(200, static_cast<std::int64_t>(image.width) * image.height / 1000);
  for (std::int32_t k = 0; k < parts.count(); ++k) {
    if (parts.sizes[k] < smallest || certainty[k] < kSure) continue;
    cv::Mat mask(image.height, image.width, CV_8U, cv::Scalar(0));
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (parts.ids[pixel_at(x, y, image.width)] == k + 1) mask.at<std::uint8_t>(y, x) = 255;
    objects.push_back(ignore(filled(mask), FoundObject::Kind::Other, section, image, ignored));
  }
}

}  // namespace terrazzo::segment
