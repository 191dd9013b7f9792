// Segment tells from the sizes of stones that a photograph was taken at an angle.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/common/io/image_file.h"
#include "nodes/photograph/segment/measure/tilt.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kBedWidth = 100, kBedHeight = 75;  // mm

// A plane seen by a camera with a field of view of 60° across `width`.
struct TiltedPlane {
  double tilt, width;
  Vec2 far;
  double focal = width / 2 / std::tan(30 * kDegree);
  TiltedPlane(double degrees, double direction, double width)
      : tilt(degrees * kDegree),
        width(width),
        far(std::cos(direction * kDegree), std::sin(direction * kDegree)) {}
  Vec2 along_across(const Vec2& p) const { return {p.dot(far), p.dot(Vec2(-far.y(), far.x()))}; }
  // Relative size of things at a point of the picture, right and up from its middle.
  double scale(const Vec2& p) const { return std::cos(tilt) - std::sin(tilt) * p.dot(far) / focal; }
  Vec2 to_plane(const Vec2& p) const {
    const Vec2 q = along_across(p);
    const double along = q.x() * focal / (focal * std::cos(tilt) - q.x() * std::sin(tilt));
    return {along, q.y() * (focal + along * std::sin(tilt)) / focal};
  }
  Vec2 to_picture(const Vec2& q) const {
    const double depth = focal + q.x() * std::sin(tilt);
    const double along = focal * q.x() * std::cos(tilt) / depth, across = focal * q.y() / depth;
    return along * far + across * Vec2(-far.y(), far.x());
  }
};

double area_of(const std::vector<Vec2>& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 &p = outline[i], &q = outline[(i + 1) % outline.size()];
    sum += p.x() * q.y() - p.y() * q.x();
  }
  return std::abs(sum) / 2;
}

// Discs with lognormal radii that lie at random on the plane; `patchy`: deviation of the mean of ln radius
// between the sixteen parts of the picture.
Profiles disc_bed(const TiltedPlane& plane, int count, std::uint64_t seed, double patchy = 0) {
  Random random(seed);
  double means[16];
  for (double& m : means) m = patchy * random.normal();
  Profiles out;
  out.view = View::Surface;
  out.window = {kBedWidth, kBedHeight};
  const Vec2 middle = out.window / 2,
             corner(plane.far.x() > 0 ? kBedWidth : 0, plane.far.y() > 0 ? kBedHeight : 0);
  const double least = plane.scale(corner - middle);
  while (count_of(out.profiles) < count) {
    const Vec2 at(random.uniform() * kBedWidth, random.uniform() * kBedHeight);
    if (random.uniform() > std::pow(least / plane.scale(at - middle), 3)) continue;  // as dense everywhere
    const double mean = means[round_down(4 * at.x() / kBedWidth) + 4 * round_down(4 * at.y() / kBedHeight)];
    const double radius = std::exp(0.25 * random.normal() + mean);
    Profile p;
    for (int k = 0; k < 24; ++k) {
      const Vec2 rim(std::cos(k * 15 * kDegree), std::sin(k * 15 * kDegree));
      p.contour.push_back(middle + plane.to_picture(plane.to_plane(at - middle) + radius * rim));
      const Vec2& q = p.contour.back();
      p.touches_border |= q.x() < 0 || q.y() < 0 || q.x() > kBedWidth || q.y() > kBedHeight;
    }
    p.centroid = at;
    p.area = p.whole = area_of(p.contour);
    if (!p.touches_border) out.profiles.push_back(std::move(p));
  }
  return out;
}

double angle_between(double a, double b) { return std::abs(std::remainder(a - b, 360)); }

TEST(SegmentTilt, IsEstimatedFromSizes) {
  for (const double tilt : {20.0, 30.0, 40.0})
    for (const double direction : {90.0, 0.0, 215.0}) {
      double sum = 0;
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(testing::Message() << tilt << "° toward " << direction << "°, seed " << seed);
        const TiltEstimate found = estimated_tilt(disc_bed({tilt, direction, kBedWidth}, 400, seed));
        EXPECT_NEAR(found.degrees, tilt, 5);
        EXPECT_LE(angle_between(found.direction, direction), 20);
        EXPECT_GT(found.factor, 1.2);
        sum += found.degrees;
      }
      EXPECT_NEAR(sum / 4, tilt, 3);
    }
}

TEST(SegmentTilt, IsNotFoundByChance) {
  int found = 0, found_in_patches = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    found += estimated_tilt(disc_bed({0, 90, kBedWidth}, 400, seed)).degrees > 0;
    // Stones of one size lie together, without a direction.
    found_in_patches += estimated_tilt(disc_bed({0, 90, kBedWidth}, 400, seed, 0.15)).degrees > 0;
  }
  EXPECT_LE(found, 1);
  EXPECT_LE(found_in_patches, 6);
}

TEST(SegmentTilt, NeedsStonesWithOutlines) {
  const TiltedPlane plane(40, 90, kBedWidth);
  EXPECT_EQ(estimated_tilt({}).degrees, 0);
  EXPECT_EQ(estimated_tilt(disc_bed(plane, 59, 1)).degrees, 0);
  Profiles unknown = disc_bed(plane, 400, 1);
  unknown.window.setZero();
  EXPECT_EQ(estimated_tilt(unknown).degrees, 0);
  Profiles bare = disc_bed(plane, 400, 1);
  for (Profile& p : bare.profiles) p.contour.clear();
  EXPECT_EQ(estimated_tilt(bare).degrees, 0);
  Profiles at_border = disc_bed(plane, 400, 1);
  for (Profile& p : at_border.profiles) p.touches_border = true;
  EXPECT_EQ(estimated_tilt(at_border).degrees, 0);
}

TEST(SegmentTilt, EqualStonesHaveNone) {
  Profiles equal;
  equal.window = {kBedWidth, kBedHeight};
  for (int k = 0; k < 100; ++k) {
    Profile p;
    p.centroid = {5.0 + k % 10 * 10, 5.0 + k / 10 * 7};
    for (const Vec2& q : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)})
      p.contour.emplace_back(p.centroid + q);
    p.area = p.whole = 4;
    equal.profiles.push_back(p);
  }
  EXPECT_EQ(estimated_tilt(equal).degrees, 0);
}

// Domes in a square grid on a tilted plane, on a dark ground.
Image photo_of_domes(double tilt) {
  const TiltedPlane plane(tilt, 90, 640);
  constexpr double kSpacing = 40, kRadius = 16;
  Image out(640, 480, 1, 0.5);
  Random random(3);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const Vec2 p = plane.to_plane({x + 0.5 - 320, 240 - y - 0.5}) / kSpacing;
      const double r = Vec2(p.x() - std::round(p.x()), p.y() - std::round(p.y())).norm() * kSpacing / kRadius;
      const double light = r < 1 ? 0.25 + 0.35 * std::sqrt(1 - r * r) : 0.03;
      out.at(x, y).setConstant(static_cast<float>(light * (1 + 0.02 * random.normal())));
    }
  return out;
}

TEST(SegmentTilt, IsAnErrorUntilItIsSet) {
  const std::string path = (test::temporary_folder() / "domes.exr").string();
  write_image(path, photo_of_domes(30));
  const std::map<std::string, std::string> clusters = {{"method", "clusters"}, {"find_objects", "false"}};
  const auto as_taken = test::run_node("LoadImage", {}, {{"path", path}}).outputs.at("image");
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Segment", {{"image", as_taken}}, clusters);
            }),
            "tilted-photograph");

  auto insisting = clusters;
  insisting["view"] = "surface";
  const auto run = test::run_node("Segment", {{"image", as_taken}}, insisting);
  EXPECT_NEAR(run.metrics.at("tilt"), 30, 5);
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_NE(run.warnings[0].find("from the bottom to the top"), std::string::npos) << run.warnings[0];

  const auto from_above =
      test::run_node("LoadImage", {}, {{"path", path}, {"tilt", "30"}, {"field_of_view", "60"}});
  const auto again = test::run_node("Segment", {{"image", from_above.outputs.at("image")}}, clusters);
  EXPECT_EQ(again.metrics.at("view_surface"), 1);
  EXPECT_LT(again.metrics.at("tilt"), 8);
}

}  // namespace
}  // namespace terrazzo
