// Rulers, tapes and scale cards by their marks.
#include "nodes/photograph/marks/scales.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "nodes/data/labels.h"
#include "nodes/photograph/marks/levels.h"
#include "nodes/photograph/marks/objects.h"
#include "tests/nodes/photograph/segment/drawn_caption.h"
#include "tests/nodes/photograph/segment/synthetic_section.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

// Stones of many colors on soil with texture.
Image stones(int width, int height, std::uint64_t seed) {
  Image image(width, height, 1, 1, Vec3f(0.12f, 0.09f, 0.06f));
  Random random(seed, 8);
  for (const auto& d : test::scatter(width, height, 130, 6, 26, seed, 1, true)) {
    const auto light = static_cast<float>(random.uniform(0.05, 0.6));
    test::draw(image, d, light * Vec3f(1, static_cast<float>(random.uniform(0.8, 1)), 0.8f));
  }
  for (auto& p : image.pixels) p *= static_cast<float>(std::exp(0.12 * random.normal()));
  return image;
}

struct Board {
  double x, y, angle, half_length, half_width;
  bool contains(double px, double py, double& along, double& across) const {
    along = std::cos(angle) * (px - x) + std::sin(angle) * (py - y);
    across = std::cos(angle) * (py - y) - std::sin(angle) * (px - x);
    return std::abs(along) < half_length && std::abs(across) < half_width;
  }
};

// A color by the place along and across, from −1 to 1 across.
using Shade = std::function<Vec3f(double along, double across)>;

void lay(Image& image, const Board& board, const Shade& shade) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      Vec3f sum = Vec3f::Zero();
      int covered = 0;
      double along = 0, across = 0;
      for (int k = 0; k < 16; ++k)
        if (board.contains(x + (k % 4 - 1.5) / 4, y + (k / 4 - 1.5) / 4, along, across))
          sum += shade(along, across / board.half_width), ++covered;
      const float share = static_cast<float>(covered) / 16;
      image.at(x, y) = (1 - share) * image.at(x, y) + sum / 16;
    }
}

Shade millimeters(double step, const Vec3f& paper, const Vec3f& ink) {
  return [=](double along, double across) {
    const auto tick = std::lround(along / step);
    const double reach = tick % 10 == 0 ? 0.2 : tick % 5 == 0 ? -0.1 : -0.4;
    return std::abs(along - static_cast<double>(tick) * step) < 0.14 * step && across < reach ? ink : paper;
  };
}

Shade blocks(double step, const Vec3f& paper, const Vec3f& ink) {
  return [=](double along, double across) {
    return (static_cast<long>(std::floor(along / step)) + (across > 0)) % 2 == 0 ? ink : paper;
  };
}

double overlap(const std::vector<std::vector<cv::Point>>& found, const Board& board, int width, int height) {
  cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
  for (const auto& corners : found) cv::fillConvexPoly(mask, corners, cv::Scalar(255));
  int both = 0, either = 0;
  double along = 0, across = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool a = mask.at<std::uint8_t>(y, x) != 0, b = board.contains(x, y, along, across);
      both += a && b;
      either += a || b;
    }
  return static_cast<double>(both) / either;
}

TEST(Scales, RulersAreFoundAtAnyAngle) {
  const Vec3f white(0.85f, 0.85f, 0.8f), black(0.01f, 0.01f, 0.01f), yellow(0.8f, 0.55f, 0.03f),
      red(0.5f, 0.02f, 0.02f);
  const struct {
    double angle, half_length, half_width;
    Shade shade;
  } all[] = {{0.02, 400, 17, millimeters(5.5, white, black)},
             {0.7, 130, 16, millimeters(7, yellow, black)},
             {1.57, 400, 15, millimeters(6, black, white)},
             {2.5, 150, 14, blocks(20, white, black)},
             {-0.4, 400, 18, blocks(30, white, red)}};
  std::uint64_t seed = 1;
  for (const auto& a : all) {
    Image image = stones(420, 360, seed++);
    const Board board{210, 180, a.angle, a.half_length, a.half_width};
    lay(image, board, a.shade);
    Random random(seed, 5);
    for (auto& p : image.pixels) p *= static_cast<float>(1 + 0.02 * random.normal());
    const auto found = find_scales(levels_of(image, 0), {}, {});
    EXPECT_GT(overlap(found, board, 420, 360), 0.6) << "at " << a.angle;
  }
}

TEST(Scales, ASectionIsNoRuler) {
  std::vector<Image> pictures;
  pictures.push_back(stones(420, 360, 9));
  const auto drawn = [&](const Shade& shade) {
    pictures.emplace_back(420, 360, 1, 1);
    lay(pictures.back(), {210, 180, 0.1, 600, 600}, shade);
  };
  const Vec3f light = Vec3f::Constant(0.6f), dark = Vec3f::Constant(0.1f);
  // Layers, a grid of squares, and courses of bricks, all of equal distances.
  drawn([=](double along, double) { return std::fmod(along + 2000, 14) < 6 ? light : dark; });
  drawn([=](double along, double across) {
    return std::fmod(along + 2000, 20) < 12 && std::fmod(600 * across + 2000, 20) < 12 ? dark : light;
  });
  drawn([=](double along, double across) {
    const double row = std::floor((600 * across + 2000) / 16);
    return std::fmod(600 * across + 2000, 16) < 3 || std::fmod(along + 2000 + 13 * row, 26) < 3 ? light
                                                                                                : dark;
  });
  // A band of uneven layers.
  Random random(3);
  std::vector<double> layer{0};
  while (layer.back() < 900) layer.push_back(layer.back() + random.uniform(4, 18));
  pictures.push_back(stones(420, 360, 10));
  lay(pictures.back(), {210, 180, 0.3, 300, 20}, [&](double along, double) {
    return (std::upper_bound(layer.begin(), layer.end(), along + 400) - layer.begin()) % 2 == 0 ? light
                                                                                                : dark;
  });
  for (std::size_t k = 0; k < pictures.size(); ++k)
    EXPECT_TRUE(find_scales(levels_of(pictures[k], 0), {}, {}).empty()) << k;
}

TEST(Scales, SegmentIgnoresARuler) {
  Image image = stones(420, 360, 2);
  const Board board{200, 170, 0.25, 400, 17};
  lay(image, board, millimeters(6, Vec3f(0.85f, 0.85f, 0.8f), Vec3f::Constant(0.01f)));
  const auto found = test::run_node("Segment", {{"image", Value::of(image)}}, {{"method", "clusters"}});
  const auto& labels = found.output<Labels>("labels");
  const auto& unobserved = found.output<Labels>("unobserved");
  int covered = 0, ignored = 0, labeled = 0;
  double along = 0, across = 0;
  for (int y = 0; y < 360; ++y)
    for (int x = 0; x < 420; ++x)
      if (board.contains(x, y, along, across)) {
        ++covered, ignored += unobserved.ids[image.index(x, y)] == 1,
            labeled += labels.ids[image.index(x, y)] > 0;
      }
  EXPECT_GT(ignored, 0.93 * covered);
  EXPECT_LT(labeled, 0.05 * covered);
  ASSERT_EQ(found.warnings.size(), 1u);
  EXPECT_NE(found.warnings[0].find("show a ruler"), std::string::npos) << found.warnings[0];
  EXPECT_NE(found.warnings[0].find("marks every 6.0"), std::string::npos) << found.warnings[0];
}

TEST(Scales, TheCardInAPhotographIsFound) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const auto file = (data / "photos" / "barton_creek.jpg").string();
  const auto loaded = test::run_node("LoadImage", {}, {{"path", file}});
  const auto found = find_scales(levels_of(loaded.output<Image>("image"), 0), {}, {});
  ASSERT_EQ(found.size(), 1u);
  const Board card{280, 1058, 0.016 - 1.5708 + 3.1416, 308, 120};  // as seen in the picture
  EXPECT_GT(overlap(found, card, 2000, 1500), 0.93);
}

}  // namespace
}  // namespace terrazzo
