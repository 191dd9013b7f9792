#include "nodes/photograph/segment/color/two_materials.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/components.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/network/candidates.h"

namespace terrazzo::segment {
namespace {

constexpr double kLeastExplained = 0.85;  // least share of the variance
constexpr double kFewestPixels = 40;      // of a part
constexpr double kLeastShare = 0.03;      // of a part in the particle
constexpr double kMostContact = 0.35;
constexpr int kMajority = 5;  // pixels, side of the window that decides on each pixel

struct Groups {
  double explained = 0;     // share of the variance of colors
  std::vector<float> side;  // −1 or 1 for each color
};

// The threshold along the main axis that explains most.
Groups group(const std::vector<Vec3f>& colors) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Vec3f& c : colors) mean += c.cast<double>() / static_cast<double>(colors.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vec3f& c : colors) {
    const Eigen::Vector3d d = c.cast<double>() - mean;
    covariance += d * d.transpose() / static_cast<double>(colors.size());
  }
  const Eigen::Vector3d axis =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(2);
  std::vector<double> along, sorted;
  for (const Vec3f& c : colors) along.push_back((c.cast<double>() - mean).dot(axis));
  sorted = along;
  std::sort(sorted.begin(), sorted.end());
  double total = 0, below = 0, best = 0, threshold = 0;
  for (const double v : sorted) total += v;
  const double n = sorted.size();
  for (std::size_t k = 0; k + 1 < sorted.size(); ++k) {
    below += sorted[k];
    const double left = static_cast<double>(k) + 1, right = n - left;
    const double apart = below / left - (total - below) / right;
    if (const double between = left * right / (n * n) * apart * apart; between > best) {
      best = between;
      threshold = sorted[k];
    }
  }
  Groups g;
  g.explained = best / std::max(covariance.trace(), 1e-12);
  for (const double v : along) g.side.push_back(v > threshold ? 1.0f : -1.0f);
  return g;
}

// Pixel numbers of the parts to split off.
using Parts = std::vector<std::vector<std::size_t>>;

Parts parts_of(const LabImage& image, const std::vector<std::int32_t>& labels, std::int32_t label,
               const cv::Rect& box) {
  std::vector<std::size_t> pixels;
  std::vector<Vec3f> colors;
  for (int y = box.y; y < box.br().y; ++y)
    for (int x = box.x; x < box.br().x; ++x)
      if (const std::size_t i = image.index(x, y); labels[i] == label) {
        pixels.push_back(i);
        colors.push_back(image.pixels[i]);
      }
  const double area = pixels.size();
  if (area < 2 * kFewestPixels) return {};
  const Groups groups = group(colors);
  if (groups.explained < kLeastExplained) return {};
  cv::Mat side(box.height, box.width, CV_32F, cv::Scalar(0)),
      inside(box.height, box.width, CV_8U, cv::Scalar(0));
  const auto place = [&](std::size_t i) {
    return cv::Point(static_cast<int>(i % image.width) - box.x, static_cast<int>(i / image.width) - box.y);
  };
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    side.at<float>(place(pixels[k])) = groups.side[k];
    inside.at<std::uint8_t>(place(pixels[k])) = 1;
  }
  cv::Mat votes;
  cv::blur(side, votes, {kMajority, kMajority}, {-1, -1}, cv::BORDER_CONSTANT);
  double more = 0;
  for (const std::size_t i : pixels) more += votes.at<float>(place(i)) > 0;
  const float sign = more > area / 2 ? 1.0f : -1.0f;
  std::vector<std::int32_t> smaller(box.area(), 0);
  for (const std::size_t i : pixels) {
    const cv::Point p = place(i);
    smaller[pixel_at(p.x, p.y, box.width)] = sign * votes.at<float>(p) < 0;
  }
  const Components components = connected_components(smaller, box.width, box.height, false);
  Parts parts(components.count());
  std::vector<double> outline(parts.size(), 0), contact(parts.size(), 0);
  for (const std::size_t i : pixels) {
    const cv::Point p = place(i);
    const auto k = components.ids[pixel_at(p.x, p.y, box.width)];
    if (k == 0) continue;
    parts[k - 1].push_back(i);
    for (const cv::Point d : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const cv::Point q = p + d;
      const bool in_box = q.x >= 0 && q.y >= 0 && q.x < box.width && q.y < box.height;
      if (in_box && components.ids[static_cast<std::size_t>(q.y) * box.width + q.x] == k) continue;
      ++outline[k - 1];
      if (in_box && inside.at<std::uint8_t>(q)) ++contact[k - 1];
    }
  }
  Parts kept;
  for (std::size_t k = 0; k < parts.size(); ++k)
    if (parts[k].size() >= std::max(kFewestPixels, kLeastShare * area) && contact[k] > 0 &&
        contact[k] <= kMostContact * outline[k])
      kept.push_back(std::move(parts[k]));
  return kept;
}

}  // namespace

std::vector<std::int32_t> split_two_materials(const LabImage& image, std::vector<std::int32_t>& labels,
                                              std::int32_t next, const Work& work) {
  const std::int32_t count = *std::max_element(labels.begin(), labels.end());
  const std::vector<cv::Rect> boxes = boxes_of_labels(labels, image.width, count);
  std::vector<Parts> parts(count);
  work.parallel(count, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      if (!boxes[k].empty()) parts[k] = parts_of(image, labels, static_cast<std::int32_t>(k) + 1, boxes[k]);
  });
  std::vector<std::int32_t> from;
  for (std::size_t k = 0; k < parts.size(); ++k)
    for (const auto& part : parts[k]) {
      for (const std::size_t i : part) labels[i] = next;
      ++next;
      from.push_back(static_cast<std::int32_t>(k) + 1);
    }
  return from;
}

}  // namespace terrazzo::segment
