// LoadImage projects photographs that were taken at an angle onto the surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/io/image_file.h"
#include "nodes/photograph/load_image/rectify.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using load_image::rectified;
using load_image::TiltOptions;
constexpr std::uint64_t kMemory = 1u << 30;

// A camera in the origin that looks along z, y up, and a surface through the point on its axis at the focal
// length, turned from the picture's plane about the line across the direction.
struct Pinhole {
  double width, height, focal;
  Eigen::Matrix3d axes;  // of the surface: right, up, normal
  Pinhole(int w, int h, const TiltOptions& o) : width(w), height(h) {
    constexpr double kDegree = std::numbers::pi / 180;
    focal = 0.5 * std::max(w, h) / std::tan(o.field_of_view / 2 * kDegree);
    const Eigen::Vector3d far(std::cos(o.direction * kDegree), std::sin(o.direction * kDegree), 0);
    axes = Eigen::AngleAxisd(o.tilt * kDegree, far.cross(Eigen::Vector3d::UnitZ())).toRotationMatrix();
  }
  // Where the ray through the middle of a pixel meets the surface, pixels right and up from the middle.
  Vec2 on_surface(int x, int y) const {
    const Eigen::Vector3d ray(x + 0.5 - width / 2, height / 2 - y - 0.5, focal), middle(0, 0, focal);
    const Eigen::Vector3d hit = ray * (middle.dot(axes.col(2)) / ray.dot(axes.col(2))) - middle;
    return {hit.dot(axes.col(0)), hit.dot(axes.col(1))};
  }
};

constexpr double kSpacing = 30, kDot = 4;

// Gaussian dots in a square grid on the surface.
Image photo_of_dots(int width, int height, const TiltOptions& o) {
  const Pinhole camera(width, height, o);
  Image out(width, height, 1, 0.5);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vec2 p = camera.on_surface(x, y) / kSpacing;
      const Vec2 off(p.x() - std::round(p.x()), p.y() - std::round(p.y()));
      const double r = kSpacing * off.norm() / kDot;
      out.at(x, y).setConstant(static_cast<float>(std::exp(-0.5 * r * r)));
    }
  return out;
}

// Centers of the dots that lie inside, weighted by light.
std::vector<Vec2> dots_of(const Image& image) {
  constexpr int kReach = 11;
  std::vector<Vec2> out;
  for (int y = kReach; y < image.height - kReach; ++y)
    for (int x = kReach; x < image.width - kReach; ++x) {
      const float v = image.at(x, y)[1];
      bool highest = v > 0.5F;
      for (int k = 0; k < 9 && highest; ++k)
        highest = k == 4 || image.at(x + k % 3 - 1, y + k / 3 - 1)[1] < v + (k < 4 ? 0 : 1e-6F);
      if (!highest) continue;
      Vec2 sum = Vec2::Zero();
      double all = 0;
      for (int j = -kReach; j <= kReach; ++j)
        for (int i = -kReach; i <= kReach; ++i) {
          const double light = image.at(x + i, y + j)[1];
          sum += light * Vec2(x + i, y + j);
          all += light;
        }
      out.emplace_back(sum / all);
    }
  return out;
}

TEST(LoadImageTilt, GivesARegularGrid) {
  const auto folder = test::temporary_folder();
  for (const TiltOptions& o :
       {TiltOptions{15, 90, 60}, TiltOptions{40, 90, 50}, TiltOptions{30, 0, 60}, TiltOptions{25, 217, 70}}) {
    SCOPED_TRACE(testing::Message() << o.tilt << "° toward " << o.direction << "°");
    const std::string path = (folder / "dots.exr").string();
    write_image(path, photo_of_dots(400, 300, o));
    const auto run = test::run_node("LoadImage", {},
                                    {{"path", path},
                                     {"pixel_size", "0.5"},
                                     {"tilt", std::to_string(o.tilt)},
                                     {"tilt_direction", std::to_string(o.direction)},
                                     {"field_of_view", std::to_string(o.field_of_view)}});
    const auto& image = run.output<Image>("image");
    EXPECT_EQ(image.pixel_size, 0.5);
    EXPECT_EQ(run.metrics.at("width"), image.width);
    EXPECT_TRUE(run.warnings.empty());
    const std::vector<Vec2> dots = dots_of(image);
    ASSERT_GT(dots.size(), 30u);
    for (const Vec2& p : dots) {  // all on one grid
      const Vec2 steps = (p - dots[0]) / kSpacing;
      const Vec2 off = kSpacing * Vec2(steps.x() - std::round(steps.x()), steps.y() - std::round(steps.y()));
      EXPECT_LT(off.norm(), 0.5) << p.transpose();
    }
  }
}

// The pixel, right and up, whose color is closest to this pixel of the photograph.
Vec2 place_of(const Image& image, const Vec2& pixel) {
  double best = 1e9;
  Vec2 out = Vec2::Zero();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3f from = image.at(x, y);
      const double distance = (Vec2(from[0] - 0.5, from[1] - 0.5) - pixel).norm();
      if (distance >= best) continue;
      best = distance;
      out = Vec2(x, -y);
    }
  return out;
}

// Colors say where in the photograph a pixel comes from.
TEST(LoadImageTilt, ShowsTheLargestRectangleInsideThePhotograph) {
  Image photo(320, 240, 1, 1);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) photo.at(x, y) = Vec3f(x + 0.5F, y + 0.5F, 1);
  for (const double direction : {90.0, -90.0, 0.0, 33.0}) {
    SCOPED_TRACE(direction);
    const TiltOptions o{30, direction, 60};
    const Image out = rectified(photo, o, kMemory, {});
    // Corners of the result are inside, and two of them at the photograph's edge.
    int at_edge = 0;
    for (const int y : {0, out.height - 1})
      for (const int x : {0, out.width - 1}) {
        const Vec3f from = out.at(x, y);
        EXPECT_NEAR(from[2], 1, 1e-5);
        const double inside = std::min({from[0], 320 - from[0], from[1], 240 - from[1]});
        EXPECT_GE(inside, 0.2);
        at_edge += inside < 2.5;
      }
    EXPECT_GE(at_edge, 2);
    // Pixels come from where their rays meet the surface.
    const Pinhole camera(320, 240, o);
    const Vec2 middle = place_of(out, {160, 120});
    for (const Vec2& p : {Vec2(100, 100), Vec2(200, 90), Vec2(150, 170)}) {
      const Vec2 step =
          camera.on_surface(round_nearest(p.x()), round_nearest(p.y())) - camera.on_surface(160, 120);
      EXPECT_LT((place_of(out, p) - middle - step).norm(), 1.5) << p.transpose();
    }
  }
}

TEST(LoadImageTilt, ZeroChangesNothing) {
  const std::string path = (test::temporary_folder() / "dots.exr").string();
  write_image(path, photo_of_dots(90, 70, {20, 90, 60}));
  const auto plain = test::run_node("LoadImage", {}, {{"path", path}});
  const auto zero = test::run_node(
      "LoadImage", {}, {{"path", path}, {"tilt", "0"}, {"tilt_direction", "17"}, {"field_of_view", "100"}});
  EXPECT_TRUE(plain.warnings.empty());
  EXPECT_EQ(plain.output<Image>("image").pixels, zero.output<Image>("image").pixels);
  EXPECT_EQ(plain.output<Image>("image").pixels, read_image(path).pixels);
  EXPECT_EQ(plain.metrics, zero.metrics);
}

TEST(LoadImageTilt, AHorizonIsAnError) {
  const std::string path = (test::temporary_folder() / "flat.png").string();
  write_image(path, Image(40, 30, 1, 1, Vec3f::Constant(0.5F)));
  const auto with = [&](const char* tilt, const char* direction, const char* field) {
    return [=] {
      test::run_node(
          "LoadImage", {},
          {{"path", path}, {"tilt", tilt}, {"tilt_direction", direction}, {"field_of_view", field}});
    };
  };
  EXPECT_EQ(test::code_of(with("55", "0", "62")), "bad-value");
  EXPECT_EQ(test::code_of(with("55", "0", "58")), "");
  EXPECT_EQ(test::code_of(with("55", "90", "62")), "");           // the shorter side reaches 24.3°
  EXPECT_EQ(test::code_of(with("55", "37", "58")), "bad-value");  // the corner 34.7°
  try {
    with("55", "0", "62")();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().parameter, "tilt");
  }
}

TEST(LoadImageTilt, TakesTheFieldOfViewFromTheFile) {
  const auto folder = test::temporary_folder();
  const auto run = [&](const std::string& name, const PictureAttributes& attributes, const char* tilt) {
    const std::string path = (folder / name).string();
    test::write_picture(path, 40, 30, 3, Sample::UInt8, std::vector<std::uint8_t>(40 * 30 * 3, 128),
                        attributes);
    return test::run_node("LoadImage", {}, {{"path", path}, {"tilt", tilt}});
  };
  const auto stated = run("a.jpg", {{"Exif:FocalLengthIn35mmFilm", 26}}, "20");
  EXPECT_TRUE(stated.warnings.empty());
  EXPECT_NEAR(stated.metrics.at("field_of_view"), 69.39, 0.01);
  const auto silent = run("b.jpg", {}, "20");
  ASSERT_EQ(silent.warnings.size(), 1u);
  EXPECT_NE(silent.warnings[0].find("set field_of_view"), std::string::npos) << silent.warnings[0];
  EXPECT_EQ(silent.metrics.at("field_of_view"), 60);
  EXPECT_TRUE(run("b.jpg", {}, "0").warnings.empty());
}

}  // namespace
}  // namespace terrazzo
