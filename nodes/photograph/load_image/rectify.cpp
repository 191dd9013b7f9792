#include "nodes/photograph/load_image/rectify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "runtime/memory.h"

namespace terrazzo::load_image {
namespace {

// Degrees from the normal up to which pixels are projected. There a pixel is already 1 / cos² = 130 times as
// long on the surface as one seen from straight above.
constexpr double kSteepest = 85;
// OpenCV keeps the places of pixels as 16 bit numbers.
constexpr int kLargestSide = 32766;
// Near the camera, up to three pixels of the photograph become one. Four samples per pixel, each between four
// of the photograph's, avoid aliasing.
constexpr int kSamples = 2;
constexpr int kRows = 64;  // per step, so that the samples need little memory
// Part of a pixel that may be missing at the rim, where the outermost pixels continue.
constexpr double kRim = 0.01;

using Corners = std::array<cv::Point2d, 4>;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

double focal_length(const Image& photo, const TiltOptions& o) {
  return 0.5 * std::max(photo.width, photo.height) / std::tan(radians(o.field_of_view / 2));
}

cv::Matx33d moved(double x, double y) { return {1, 0, x, 0, 1, y, 0, 0, 1}; }

// Where a point of the surface lies in the photograph; both in pixels to the right and down, on the surface
// from the point at the photograph's middle, in the photograph from its corner.
//
// Let the middle be f pixels away, with f the focal length. The camera turns by the tilt T about the line
// across the direction, so a point l along the direction and c across it lies l·cos T along, c across and
// f + l·sin T deep, and projects to f·l·cos T / (f + l·sin T) and f·c / (f + l·sin T).
cv::Matx33d photo_of_surface(const Image& photo, const TiltOptions& o) {
  const double t = radians(o.tilt), a = radians(o.direction), f = focal_length(photo, o);
  const cv::Matx33d along(std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1);
  const cv::Matx33d project(std::cos(t), 0, 0, 0, 1, 0, std::sin(t) / f, 0, 1);
  return moved(0.5 * photo.width, 0.5 * photo.height) * along.t() * project * along;
}

// The largest angle from the surface's normal at which the picture shows it, degrees.
double steepest_angle(const Image& photo, const TiltOptions& o) {
  const double a = radians(o.direction);
  const double reach = 0.5 * (std::abs(std::cos(a)) * photo.width + std::abs(std::sin(a)) * photo.height);
  return o.tilt + std::atan(reach / focal_length(photo, o)) * 180 / std::numbers::pi;
}

Corners corners_on_surface(const Image& photo, const cv::Matx33d& to_photo) {
  const cv::Matx33d to_surface = to_photo.inv();
  const double w = photo.width, h = photo.height;
  Corners out = {cv::Point2d(0, 0), cv::Point2d(w, 0), cv::Point2d(w, h), cv::Point2d(0, h)};
  for (cv::Point2d& p : out) {
    const cv::Vec3d q = to_surface * cv::Vec3d(p.x, p.y, 1);
    p = {q[0] / q[2], q[1] / q[2]};
  }
  return out;
}

// Where the vertical line at x cuts the convex quadrilateral: from above to below; from infinity to -infinity
// if it does not.
cv::Vec2d cut_at(const Corners& corners, double x) {
  cv::Vec2d out(std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < 4; ++k) {
    const cv::Point2d &p = corners[k], &q = corners[(k + 1) % 4];
    if (x < std::min(p.x, q.x) || x > std::max(p.x, q.x)) continue;
    const double share = p.x == q.x ? 0 : (x - p.x) / (q.x - p.x);
    const double y = p.y + share * (q.y - p.y);
    out[0] = std::min(out[0], y);
    out[1] = std::max(out[1], y);
  }
  return out;
}

// Where `value`, which rises and then falls, is largest. 80 steps leave (2/3)^80 of the range.
template <class Value>
double highest(double low, double high, const Value& value) {
  for (int step = 0; step < 80; ++step) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (value(a) < value(b))
      low = a;
    else
      high = b;
  }
  return 0.5 * (low + high);
}

// The largest upright rectangle in a convex quadrilateral. Its width and its height are concave functions of
// its left and right ends, so its area has no local maxima.
cv::Rect2d largest_rectangle(const Corners& corners) {
  const auto [first, last] = std::minmax({corners[0].x, corners[1].x, corners[2].x, corners[3].x});
  const double most = last;
  const auto score = [&](double left, double right) {
    const cv::Vec2d a = cut_at(corners, left), b = cut_at(corners, right);
    const double height = std::min(a[1], b[1]) - std::max(a[0], b[0]);
    return height < 0 ? height : height * (right - left);
  };
  const auto best_right = [&](double left) {
    return highest(left, most, [&](double right) { return score(left, right); });
  };
  const double left = highest(first, last, [&](double x) { return score(x, best_right(x)); });
  const double right = best_right(left);
  const cv::Vec2d a = cut_at(corners, left), b = cut_at(corners, right);
  const double top = std::max(a[0], b[0]), bottom = std::min(a[1], b[1]);
  return {left, top, right - left, bottom - top};
}

void require_visible(const Image& photo, const TiltOptions& o) {
  const double angle = steepest_angle(photo, o);
  if (angle >= kSteepest)
    throw Error(
        "bad-value",
        fmt::format("with a tilt of {:g}° and a field of view of {:.3g}°, the picture reaches {:.1f}° from "
                    "the surface's normal; the horizon is at 90°, and only {:g}° can be rectified",
                    o.tilt, o.field_of_view, angle, kSteepest),
        "set a smaller tilt or field_of_view, or take the photograph from further above")
        .parameter("tilt");
  if (std::max(photo.width, photo.height) > kLargestSide)
    throw Error("too-large",
                fmt::format("the picture has {} × {} pixels; at most {} in a row can be rectified",
                            photo.width, photo.height, kLargestSide),
                "reduce the picture, or set tilt to 0")
        .parameter("tilt");
}

}  // namespace

Image rectified(const Image& photo, const TiltOptions& o, std::uint64_t memory, const Work& work) {
  require_visible(photo, o);
  const cv::Matx33d to_photo = photo_of_surface(photo, o);
  const cv::Rect2d covered = largest_rectangle(corners_on_surface(photo, to_photo));
  const int width = round_down(covered.width + kRim), height = round_down(covered.height + kRim);
  if (width < 1 || height < 1)
    throw Error("too-small", "no pixel of the rectified picture is covered by the photograph",
                "use a larger picture, or a smaller tilt")
        .parameter("tilt");
  require_memory(1.0 * sizeof(Vec3f) * width * height, memory,
                 fmt::format("the rectified picture of {} × {} pixels", width, height));
  Image out(width, height, 1, photo.pixel_size);
  // OpenCV only reads it.
  const cv::Mat from(photo.height, photo.width, CV_32FC3, const_cast<Vec3f*>(photo.pixels.data()));
  // In OpenCV, whole numbers are the middles of pixels.
  const cv::Matx33d from_samples = cv::Matx33d::diag({1.0 / kSamples, 1.0 / kSamples, 1}) * moved(0.5, 0.5);
  work.parallel(height, kRows, [&](std::size_t begin, std::size_t end) {
    const int rows = static_cast<int>(end - begin);
    const cv::Matx33d place = moved(covered.x, covered.y + static_cast<double>(begin)) * from_samples;
    cv::Mat samples;
    cv::warpPerspective(from, samples, moved(-0.5, -0.5) * to_photo * place,
                        cv::Size(kSamples * width, kSamples * rows), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                        cv::BORDER_REPLICATE);
    cv::Mat to(rows, width, CV_32FC3, out.pixels.data() + begin * width);
    cv::resize(samples, to, to.size(), 0, 0, cv::INTER_AREA);
  });
  return out;
}

}  // namespace terrazzo::load_image
