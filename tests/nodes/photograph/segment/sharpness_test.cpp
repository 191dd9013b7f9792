// The blur of photographs, and what it is measured for.
#include "nodes/photograph/segment/network/sharpness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/photograph/instance_score/instance_score.h"
#include "nodes/photograph/segment/segment.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"

namespace terrazzo {
namespace {
using namespace segment;

float to_linear(double v) {
  return static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
}

// Light discs on a dark ground with edges that are Gaussian integrals, and white noise.
Image blurred_discs(int side, double sigma, double noise) {
  Image image(side, side, 1, 1);
  std::uint64_t state = 1;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double dx = std::remainder(x, 40.0), dy = std::remainder(y, 40.0);
      const double depth = 12 - std::hypot(dx, dy);
      state = state * 6364136223846793005u + 1442695040888963407u;
      const double u = static_cast<double>(state >> 11) / 9007199254740992.0 - 0.5;
      const double v = 0.5 + 0.25 * std::erf(depth / (sigma * std::numbers::sqrt2)) + noise * u;
      image.at(x, y) = Vec3f::Constant(to_linear(v));
    }
  return image;
}

Image enlarged(const Image& image, int times) {
  Image out(image.width * times, image.height * times, 1, 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const double u = std::clamp((x + 0.5) / times - 0.5, 0.0, image.width - 1.0),
                   v = std::clamp((y + 0.5) / times - 0.5, 0.0, image.height - 1.0);
      const int i = std::min(image.width - 2, static_cast<int>(u)),
                j = std::min(image.height - 2, static_cast<int>(v));
      const auto a = static_cast<float>(u - i), b = static_cast<float>(v - j);
      out.at(x, y) = (1 - b) * ((1 - a) * image.at(i, j) + a * image.at(i + 1, j)) +
                     b * ((1 - a) * image.at(i, j + 1) + a * image.at(i + 1, j + 1));
    }
  return out;
}

TEST(Sharpness, MeasuresTheBlurOfEdges) {
  for (const double sigma : {1.2, 2.0, 3.0})
    for (const double noise : {0.0, 0.03})
      EXPECT_NEAR(blur_of(blurred_discs(400, sigma, noise), 1) / sigma, 1, 0.2) << sigma << ' ' << noise;
}

TEST(Sharpness, OfAReducedPictureIsInItsPixels) {
  const Image image = blurred_discs(800, 3, 0);
  EXPECT_NEAR(blur_of(image, 0.5), 1.5, 0.3);
}

TEST(Sharpness, SharpPicturesAreNotReduced) {
  EXPECT_EQ(network_scale_of(blurred_discs(900, 0.8, 0.02)), 1);
  EXPECT_EQ(network_scale_of(blurred_discs(900, 1.3, 0)), 1);
}

TEST(Sharpness, SoftPicturesAreReducedAsFarAsTheirSizeAllows) {
  const double large = network_scale_of(blurred_discs(2000, 4, 0));
  EXPECT_GT(large, 0.512 / 2) << "no further than needed";
  EXPECT_LT(large, 0.4);
  EXPECT_DOUBLE_EQ(network_scale_of(blurred_discs(600, 4, 0)), 512.0 / 600);
  EXPECT_EQ(network_scale_of(blurred_discs(300, 4, 0)), 1);
}

TEST(Sharpness, APictureOfOneColorHasNone) {
  Image image(600, 700, 1, 1);
  image.pixels.assign(image.pixels.size(), Vec3f::Constant(0.3f));
  EXPECT_EQ(network_scale_of(image), 1);
}

// An enlarged photograph shows what the photograph shows, and so do its particles.
TEST(Sharpness, AnEnlargedPhotographGivesAboutTheSameParticles) {
  synthetic_photo::PhotoOptions options;
  options.seed = 21;
  options.width = options.height = 300;
  const synthetic_photo::Photo photo = synthetic_photo::take_photo(options, {});
  SegmentOptions how;
  how.method = Method::Network;
  const Segmentation small = segment::segment(photo.image, how, {});
  const Image large_image = enlarged(photo.image, 3);
  const Segmentation large = segment::segment(large_image, how, {});
  EXPECT_EQ(small.network_scale, 1);
  EXPECT_LT(large.network_scale, 0.7);
  Labels reduced = small.labels;
  for (int y = 0; y < reduced.height; ++y)
    for (int x = 0; x < reduced.width; ++x)
      reduced.ids[static_cast<std::size_t>(y) * reduced.width + x] =
          large.labels.ids[static_cast<std::size_t>(3 * y + 1) * large.labels.width + 3 * x + 1];
  reduced.classes = large.labels.classes;
  double alike = 0;
  for (std::size_t i = 0; i < reduced.ids.size(); ++i)
    alike += (reduced.ids[i] > 0) == (small.labels.ids[i] > 0);
  EXPECT_GT(alike / static_cast<double>(reduced.ids.size()), 0.8);
  EXPECT_NEAR(static_cast<double>(large.labels.count()) / small.labels.count(), 1, 0.3);
}

}  // namespace
}  // namespace terrazzo
