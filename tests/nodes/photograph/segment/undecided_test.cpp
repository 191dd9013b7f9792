// Pixels that show neither a particle that was found nor surely binder.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nodes/photograph/segment/measure/measure.h"
#include "nodes/photograph/segment/segment.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

TEST(Undecided, IsNotObservedButCutsNoProfile) {
  const int W = 40, H = 30;
  Image image(W, H, 1, 0.5, Vec3f::Constant(0.2f));
  Labels labels;
  labels.width = W;
  labels.height = H;
  labels.pixel_size = 0.5;
  labels.ids.assign(W * H, 0);
  labels.classes = {0};
  std::vector<float> coverage(W * H, 0);
  UndecidedPixels undecided(W * H, 0);
  for (int y = 10; y < 16; ++y)
    for (int x = 10; x < 16; ++x) labels.ids[y * W + x] = 1, coverage[y * W + x] = 1;
  for (int y = 10; y < 16; ++y)
    for (int x = 16; x < 30; ++x) undecided[y * W + x] = 1, image.at(x, y).setConstant(0.9f);
  const Profiles all = measure_profiles(image, labels, coverage, {}, {}, {});
  const Profiles p = measure_profiles(image, labels, coverage, {}, undecided, {});
  EXPECT_DOUBLE_EQ(all.observed_area, 0.25 * W * H);
  EXPECT_DOUBLE_EQ(p.observed_area, 0.25 * (W * H - 84));
  EXPECT_DOUBLE_EQ(p.area_fraction, 36.0 / (W * H - 84));
  ASSERT_EQ(p.fragments.size(), 1u);
  EXPECT_NEAR(p.fragments[0].area, 0.25 * 84, 1e-9);
  EXPECT_NEAR(p.fragments[0].color[0], 0.9f, 1e-6);
  EXPECT_TRUE(all.fragments.empty());
  EXPECT_FALSE(p.profiles[0].touches_border);
  EXPECT_EQ(p.profiles[0].weight, all.profiles[0].weight);
  EXPECT_NEAR(p.binder_color[0], 0.2f, 1e-6);
  EXPECT_GT(all.binder_color[0], 0.21f);
}

// The mean of each 2 × 2 pixels.
Image half_as_large(const Image& image) {
  Image half(image.width / 2, image.height / 2, 1, 2 * image.pixel_size);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      half.at(x, y) = (image.at(2 * x, 2 * y) + image.at(2 * x + 1, 2 * y) + image.at(2 * x, 2 * y + 1) +
                       image.at(2 * x + 1, 2 * y + 1)) /
                      4;
  return half;
}

// The network misses stones of heaps where they are small. The area fraction of the rest of the picture is
// closer to the truth.
TEST(Undecided, MissedStonesOfHeapsAreNoBinder) {
  double by_labels = 0, by_rest = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    synthetic_photo::PhotoOptions o;
    o.scene = synthetic_photo::Scene::Heap;
    o.seed = 900000 + seed;
    o.objects = false;
    const auto photo = synthetic_photo::take_photo(o, {});
    const Image image = half_as_large(photo.image);
    const auto found = test::run_node("Segment", {{"image", Value::of(image)}}, {{"method", "network"}});
    const auto fraction = [](const Labels& l) {
      return std::count_if(l.ids.begin(), l.ids.end(), [](auto id) { return id > 0; }) /
             static_cast<double>(l.ids.size());
    };
    const double truth = fraction(photo.labels);
    by_labels += std::abs(fraction(found.output<Labels>("labels")) - truth) / 5;
    by_rest += std::abs(found.output<Profiles>("profiles").area_fraction - truth) / 5;
    // What is unobserved has no label, and is as much as the profiles say.
    const Labels& unobserved = found.output<Labels>("unobserved");
    std::size_t count = 0;
    for (std::size_t i = 0; i < unobserved.ids.size(); ++i) {
      if (unobserved.ids[i] == 0) continue;
      ++count;
      ASSERT_EQ(found.output<Labels>("labels").ids[i], 0);
    }
    const double pixel = image.pixel_size * image.pixel_size;
    EXPECT_NEAR(found.output<Profiles>("profiles").observed_area,
                pixel * static_cast<double>(unobserved.ids.size() - count), 1e-6 * pixel);
  }
  EXPECT_GT(by_labels, 0.1);
  EXPECT_LT(by_rest, 0.8 * by_labels);
}

TEST(Undecided, DroppedParticlesAreNoBinder) {
  synthetic_photo::PhotoOptions o;
  o.scene = synthetic_photo::Scene::Bank;
  o.seed = 900001;
  o.objects = false;
  o.fill = 0.4;
  const auto photo = synthetic_photo::take_photo(o, {});
  const auto all = test::run_node("Segment", {{"image", Value::of(photo.image)}}, {{"method", "network"}});
  const auto sure = test::run_node("Segment", {{"image", Value::of(photo.image)}},
                                   {{"method", "network"}, {"min_confidence", "0.8"}});
  ASSERT_GT(sure.metrics.at("unlikely_dropped"), 0);
  const Labels &before = all.output<Labels>("labels"), &after = sure.output<Labels>("labels");
  const Labels& unobserved = sure.output<Labels>("unobserved");
  for (std::size_t i = 0; i < before.ids.size(); ++i)
    if (before.ids[i] > 0 && after.ids[i] == 0) {
      ASSERT_EQ(unobserved.ids[i], 2);
    }
}

}  // namespace
}  // namespace terrazzo
