// Tests the texture and outline measures of Compare.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/texture/phase_statistics.h"
#include "nodes/common/texture/texture_measures.h"
#include "nodes/compare/compare/comparison.h"
#include "nodes/photograph/segment/outline/outline.h"
#include "runtime/random.h"
#include "tests/nodes/compare/compare/exceeding.h"

namespace terrazzo {
namespace {
using namespace compare;

double number(const Comparison& c, const std::string& measure, const std::string& item,
              bool tolerance = false) {
  for (const auto& n : c.numbers)
    if (n.measure == measure && n.item == item) return tolerance ? n.tolerance : n.b;
  ADD_FAILURE() << measure << ": " << item;
  return NAN;
}

// Disks of one radius on a light background, with noise. The pattern is tileable.
Image discs(std::uint64_t seed, double radius, int count, int edge = 160) {
  Image image(edge, edge, 1, 1, Vec3f::Constant(0.6f));
  for (int i = 0; i < count; ++i) {
    Random r(seed, 1, static_cast<std::uint64_t>(i));
    const double x0 = r.uniform(0, edge), y0 = r.uniform(0, edge);
    for (int y = 0; y < edge; ++y)
      for (int x = 0; x < edge; ++x) {
        double dx = x - x0, dy = y - y0;
        dx -= edge * std::round(dx / edge);
        dy -= edge * std::round(dy / edge);
        if (dx * dx + dy * dy < radius * radius) image.at(x, y) = Vec3f(0.1f, 0.08f, 0.06f);
      }
  }
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] *= static_cast<float>(1 + 0.05 * Random(seed, 2, i).normal());
  return image;
}

TEST(PhaseStatistics, OfStripesAndNoise) {
  Phase stripes{40, 30, {}};
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) stripes.in.push_back(x / 5 % 2 == 0);
  const PhaseStatistics s = phase_statistics({stripes}, 12);
  EXPECT_NEAR(s.two_point[0], 0.5, 1e-12);
  EXPECT_NEAR(s.lineal_path[0], 0.5, 1e-12);
  // Along the stripes, a segment of 5 pixels stays in its stripe. Across them (width 5), it never does, and
  // its ends are never both in stripes.
  const double down = 40 * (30 - 5) * 0.5, all = 30 * (40 - 5) + 40 * (30 - 5);
  EXPECT_NEAR(s.lineal_path[5], down / all, 1e-12);
  EXPECT_NEAR(s.two_point[5], down / all, 1e-12);
  Phase noise{300, 300, {}};
  for (std::uint64_t i = 0; i < 90000; ++i) noise.in.push_back(Random(3, 0, i).uniform() < 0.4);
  const PhaseStatistics n = phase_statistics({noise}, 6);
  for (std::size_t r = 1; r <= 6; ++r) {
    EXPECT_NEAR(n.two_point[r], 0.16, 0.004);
    EXPECT_NEAR(n.lineal_path[r], std::pow(0.4, r + 1), 0.004);
  }
}

TEST(CompareTextures, OneTextureTwiceStaysWithinItsHalves) {
  const Image a = discs(1, 7, 115), b = discs(2, 7, 115);
  const Comparison same = compare::compare(a, a, {}), c = compare::compare(a, b, {});
  for (const char* measure : {"bands", "patches", "two_point", "lineal_path"}) {
    EXPECT_EQ(exceeding(same, measure), 0) << measure;
    // Halves usually differ more than whole images, but not always.
    EXPECT_LE(exceeding(c, measure), measure == std::string("bands") ? 2 : 1) << measure;
  }
  EXPECT_EQ(number(same, "two_point", "largest difference"), 0);
  EXPECT_EQ(same.metrics.at("band_distance"), 0);
  EXPECT_EQ(same.metrics.at("band_ratio_least"), 1);
}

TEST(CompareTextures, LargerGrainsOfTheSameColorsAreFoundOut) {
  const Comparison c = compare::compare(discs(1, 5, 900, 320), discs(2, 12, 156, 320), {});
  EXPECT_GT(exceeding(c, "bands"), 2);
  EXPECT_EQ(exceeding(c, "lineal_path"), 1);
  EXPECT_EQ(exceeding(c, "two_point"), 1);
  EXPECT_GE(exceeding(c, "patches"), 1);
}

TEST(CompareTextures, BlurLowersTheFinestBand) {
  const Image a = discs(1, 7, 115);
  Image b = a;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      b.at(x, y) = (a.at(x, y) + a.at((x + 1) % a.width, y) + a.at(x, (y + 1) % a.height) +
                    a.at((x + 1) % a.width, (y + 1) % a.height)) /
                   4;
  const Comparison c = compare::compare(a, b, {});
  EXPECT_LT(c.metrics.at("band_ratio_least"), 0.5);
  EXPECT_EQ(
      c.metrics.at("band_ratio_least"), number(c, "bands", "finest, deviation") / [&] {
        for (const auto& n : c.numbers)
          if (n.item == "finest, deviation") return n.a;
        return 0.0;
      }());
}

TEST(CompareTextures, SeamsAreWhereThePictureDoesNotTile) {
  const Image a = discs(1, 7, 115);
  Image shaded = a;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      shaded.at(x, y) *= 1 + 2 * static_cast<float>(x) / static_cast<float>(a.width);
  const Comparison c = compare::compare(a, shaded, {});
  EXPECT_NEAR(number(c, "seam", "across y"), 1, 0.6);
  EXPECT_GT(c.metrics.at("seam_x"), 3);
  EXPECT_EQ(exceeding(c, "seam"), 0);  // seam has no tolerance
}

TEST(CompareTextures, SmallPicturesAreComparedByColorAlone) {
  const Comparison c = compare::compare(discs(1, 3, 5, 40), discs(2, 3, 5, 40), {});
  ASSERT_EQ(c.warnings.size(), 1u);
  for (const auto& n : c.numbers) EXPECT_EQ(n.measure, "color");
  Image coarse = discs(1, 7, 115);
  coarse.pixel_size = 2;
  EXPECT_EQ(compare::compare(discs(1, 7, 115), coarse, {}).warnings.size(), 1u);
}

TEST(NearestPatch, OfItselfIsNearAndOfAnotherFar) {
  const auto picture = [](const Image& image) {
    return PatchPicture{image.width, image.height, image.pixels, {}};
  };
  const PatchPicture a = picture(discs(1, 7, 20, 64)), b = picture(discs(2, 7, 20, 64));
  PatchPicture light = a;
  for (Vec3f& c : light.pixels) c += Vec3f::Constant(0.5f);
  const double itself = nearest_patch({a}, {a}, 0.5), other = nearest_patch({a}, {b}, 0.5);
  EXPECT_LT(itself, other);
  EXPECT_GT(nearest_patch({a}, {light}, 0.5), 0.25);
  EXPECT_LE(other, nearest_patch({a}, {b}, 0.95));
  EXPECT_LT(nearest_patch({a}, {PatchPicture{4, 4, std::vector<Vec3f>(16, Vec3f::Zero()), {}}}, 0.5), 0);
}

// Ellipses with a given aspect ratio, or squares.
Profiles outlines(std::uint64_t seed, int count, double ratio, bool square = false) {
  Profiles p;
  p.observed_area = 1000;
  for (int i = 0; i < count; ++i) {
    Random r(seed, 4, static_cast<std::uint64_t>(i));
    const double size = r.uniform(0.5, 2), slim = ratio * r.uniform(0.9, 1.1), turn = r.uniform(0, 6.28);
    Profile q;
    for (int k = 0; k < 64; ++k) {
      const double t = k * 2 * M_PI / 64;
      Vec2 v(std::cos(t), slim * std::sin(t));
      if (square) v /= std::max(std::abs(std::cos(t)), std::abs(std::sin(t)));
      q.contour.push_back(size * (Eigen::Rotation2Dd(turn) * v));
    }
    q.area = size * size * slim;
    p.profiles.push_back(q);
  }
  return p;
}

TEST(CompareOutlines, ShapesAreToldFromNoise) {
  const Profiles a = outlines(1, 300, 0.8);
  int exceeds = 0;
  for (std::uint64_t seed = 2; seed < 22; ++seed) {
    const Comparison c = compare::compare(a, outlines(seed, 200, 0.8), {});
    exceeds += exceeding(c, "circularity");
    EXPECT_NEAR(c.metrics.at("total_curvature_b"), 2 * M_PI, 0.02);
  }
  EXPECT_LE(exceeds, 6);  // of forty; two exceed by chance
  EXPECT_EQ(exceeding(compare::compare(a, outlines(2, 200, 0.6), {}), "circularity"), 2);
  EXPECT_EQ(exceeding(compare::compare(a, outlines(2, 200, 0.8, true), {}), "circularity"), 2);
  EXPECT_EQ(number(compare::compare(a, a, {}), "circularity", "Kolmogorov–Smirnov distance"), 0);
}

// The same outlines as they come from pixels of 1/12 mm, which are inside or outside.
Profiles stepped(Profiles p) {
  constexpr int kPixels = 80;
  constexpr double kPerMm = 12;
  for (Profile& q : p.profiles) {
    std::vector<std::int32_t> labels;
    for (int y = 0; y < kPixels; ++y)
      for (int x = 0; x < kPixels; ++x) {
        const Vec2 at = Vec2(x + 0.5 - kPixels / 2.0, kPixels / 2.0 - y - 0.5) / kPerMm;
        bool inside = false;
        for (std::size_t k = 0; k < q.contour.size(); ++k) {
          const Vec2 &a = q.contour[k], &b = q.contour[(k + 1) % q.contour.size()];
          if ((a.y() > at.y()) == (b.y() > at.y())) continue;
          inside ^= at.x() < a.x() + (at.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        }
        labels.push_back(inside);
      }
    const std::vector<float> coverage(labels.begin(), labels.end());
    q.contour = segment::outlines(labels, coverage, kPixels, kPixels, 1, {})[0].points;
    for (Vec2& v : q.contour) v /= kPerMm;
  }
  return p;
}

TEST(CompareOutlines, PixelStepsCountOnNeitherSide) {
  const Profiles a = outlines(1, 200, 0.8), pixels = stepped(outlines(2, 200, 0.8));
  const Comparison c = compare::compare(pixels, a, {});
  EXPECT_EQ(exceeding(c, "total_curvature"), 0);
  EXPECT_EQ(exceeding(c, "circularity"), 0);
  // What is wider than pixels is still seen.
  const Comparison square = compare::compare(pixels, outlines(3, 200, 0.8, true), {});
  EXPECT_EQ(exceeding(square, "circularity"), 2);
}

TEST(CompareOutlines, CutProfilesDoNotCountAndNoneIsSaid) {
  Profiles a = outlines(1, 50, 0.8), b = a;
  for (std::size_t i = 0; i < 25; ++i) {
    b.profiles[i].touches_border = true;
    for (Vec2& v : b.profiles[i].contour) v.y() *= 0.1;
  }
  EXPECT_EQ(exceeding(compare::compare(a, b, {}), "circularity"), 0);
  for (Profile& q : b.profiles) q.contour.clear();
  Comparison c = compare::compare(a, b, {});
  EXPECT_EQ(c.metrics.count("circularity_a"), 0u);
  const std::size_t before = c.warnings.size();
  b.profiles[30].contour = a.profiles[30].contour;  // one outline is not a sample
  c = compare::compare(a, b, {});
  EXPECT_EQ(c.warnings.size(), before + 2);
  EXPECT_EQ(c.metrics.count("circularity_a"), 0u);
}

}  // namespace
}  // namespace terrazzo
