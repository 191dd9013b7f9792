// Close-ups of candidates and the outlines that the second network draws in them.
#include "nodes/photograph/segment/network/close_look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/photograph/segment/network/network_particles.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace segment;

constexpr int kWidth = 120, kHeight = 90;

std::vector<std::int32_t> disc(double cx, double cy, double radius) {
  std::vector<std::int32_t> labels(kWidth * kHeight, 0);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) labels[y * kWidth + x] = std::hypot(x - cx, y - cy) < radius;
  return labels;
}

Cutout region(const std::vector<std::int32_t>& labels) {
  return cut_out_label(labels, kWidth, kHeight, 1, boxes_of_labels(labels, kWidth, 1)[0]);
}

// A network that sees this disc everywhere, blurred as on photographs.
ScaleView view_of(const std::vector<std::int32_t>& labels) {
  NetworkMaps maps;
  maps.width = kWidth;
  maps.height = kHeight;
  for (const auto id : labels) maps.inside.push_back(static_cast<float>(id));
  cv::Mat inside(kHeight, kWidth, CV_32F, maps.inside.data());
  cv::GaussianBlur(inside, inside, {0, 0}, 3);
  maps.border.assign(labels.size(), 0.1f), maps.distance = maps.inside,
                                           maps.not_material.assign(labels.size(), 0);
  return {std::move(maps), 1, {}};
}

cv::Mat picture_of(const std::vector<std::int32_t>& labels) {
  cv::Mat out(kHeight, kWidth, CV_32FC3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      out.at<cv::Vec3f>(y, x) =
          labels[y * kWidth + x] ? cv::Vec3f(0.7f, 0.6f, 0.5f) : cv::Vec3f(0.3f, 0.35f, 0.3f);
  return out;
}

TEST(CloseUp, ShowsTheCandidateAtHalfItsWidth) {
  const auto labels = disc(60, 45, 15);
  const ScaleView view = view_of(labels);
  const CloseUp seen = close_up(region(labels), picture_of(labels), view, view);
  EXPECT_EQ(seen.square.width, seen.square.height);
  EXPECT_NEAR(seen.square.width, 2 * 30, 3);
  EXPECT_NEAR(seen.square.x + seen.square.width / 2.0, 60, 1);
  EXPECT_NEAR(seen.square.y + seen.square.height / 2.0, 45, 1);
  double square = 0;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(cv::mean(seen.planes[k])[0], 0, 1e-5);
    square += cv::mean(seen.planes[k].mul(seen.planes[k]))[0] / 3;
  }
  EXPECT_NEAR(std::sqrt(square), 0.87, 0.05);  // one but for the constant that limits the gain
  EXPECT_NEAR(cv::mean(seen.planes[3])[0], 3.1416 * 15 * 15 / seen.square.area(), 0.01);
  EXPECT_NEAR(seen.planes[9].at<float>(7, 7), std::log2(seen.square.width / 48.0), 1e-6);
  for (const cv::Mat& plane : seen.planes) EXPECT_EQ(plane.size(), cv::Size(kCloseUp, kCloseUp));
}

TEST(CloseUp, SmallOnesAreSeenWithTheirSurroundingsAndCornersWithRepeatedEdges) {
  const auto small = disc(30, 30, 3), corner = disc(1, 1, 20);
  const ScaleView view = view_of(small);
  EXPECT_EQ(close_up(region(small), picture_of(small), view, view).square.width, 24);
  const CloseUp seen = close_up(region(corner), picture_of(corner), view_of(corner), view_of(corner));
  EXPECT_LT(seen.square.x, 0);
  EXPECT_EQ(seen.planes[3].at<float>(0, 0), 0);  // the candidate ends with the section
  EXPECT_GT(seen.planes[7].at<float>(0, 0), 0.5f);
  for (const cv::Mat& plane : seen.planes) EXPECT_TRUE(cv::checkRange(plane));
}

TEST(CloseLook, OutlinesAreOnePieceWithoutHoles) {
  const auto labels = disc(60, 45, 15);
  const ScaleView view = view_of(labels);
  const Cutout candidate = region(labels);
  const CloseUp seen = close_up(candidate, picture_of(labels), view, view);
  cv::Mat logits(kCloseUp, kCloseUp, CV_32F, cv::Scalar(-3));
  cv::circle(logits, {24, 24}, 10, cv::Scalar(3), cv::FILLED);
  cv::circle(logits, {24, 24}, 2, cv::Scalar(-3), cv::FILLED);
  cv::circle(logits, {4, 4}, 3, cv::Scalar(3), cv::FILLED);
  const Cutout after = redrawn(candidate, seen, logits, {kWidth, kHeight});
  EXPECT_NEAR(after.area(), 3.1416 * std::pow(10.5 * seen.square.width / 48.0, 2), 60);
  EXPECT_NEAR(overlap_of(candidate, after), static_cast<double>(after.area()) / candidate.area(), 0.01);
  logits.setTo(-1);
  EXPECT_EQ(redrawn(candidate, seen, logits, {kWidth, kHeight}).area(), 0);
}

TEST(CloseLook, OverlapsAreThoseOfTheirPixels) {
  const Cutout a = region(disc(40, 40, 12)), b = region(disc(46, 40, 12)), far = region(disc(90, 40, 12));
  std::vector<std::int32_t> shared;
  const auto pa = a.pixels(kWidth), pb = b.pixels(kWidth);
  std::set_intersection(pa.begin(), pa.end(), pb.begin(), pb.end(), std::back_inserter(shared));
  EXPECT_NEAR(overlap_of(a, b), static_cast<double>(shared.size()) / (pa.size() + pb.size() - shared.size()),
              1e-12);
  EXPECT_EQ(overlap_of(a, a), 1);
  EXPECT_EQ(overlap_of(a, far), 0);
}

TEST(CloseLook, MovesWrongOutlinesToTheParticle) {
  const auto truth = disc(60, 45, 15);
  const ScaleView view = view_of(truth);
  const cv::Mat picture = picture_of(truth);
  std::vector<CloseUp> close_ups;
  const std::vector<Cutout> candidates{region(disc(60, 45, 10)), region(disc(60, 45, 20)),
                                       region(disc(66, 45, 14))};
  for (const Cutout& c : candidates) close_ups.push_back(close_up(c, picture, view, view));
  const auto logits = built_in_close_look()(close_ups);
  ASSERT_EQ(logits.size(), candidates.size());
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const Cutout after = redrawn(candidates[k], close_ups[k], logits[k], {kWidth, kHeight});
    EXPECT_GT(overlap_of(after, region(truth)), overlap_of(candidates[k], region(truth)) + 0.1) << k;
  }
  // Close-ups do not change each other.
  const auto alone = built_in_close_look()(std::span(close_ups).subspan(1, 1));
  EXPECT_EQ(cv::norm(alone[0], logits[1], cv::NORM_INF), 0);
  EXPECT_TRUE(built_in_close_look()({}).empty());
}

TEST(CloseLook, OtherFilesAreRefused) {
  for (const std::string& bytes : {std::string(), std::string("no model")})
    EXPECT_EQ(test::code_of([&] { CloseLook look(bytes); }), "bad-model");
  const CloseLook network(built_in_model());  // a model, but not of close-ups
  const auto labels = disc(60, 45, 15);
  const ScaleView view = view_of(labels);
  const CloseUp seen = close_up(region(labels), picture_of(labels), view, view);
  EXPECT_EQ(test::code_of([&] { network(std::span(&seen, 1)); }), "bad-model");
}

}  // namespace
}  // namespace terrazzo
