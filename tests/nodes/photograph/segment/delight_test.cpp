#include "nodes/photograph/segment/color/delight.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/photograph/segment/segment.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

// Domes of known colors on a gray ground, lit from one side, with uneven light, gloss and noise.
struct Lit {
  Image image{300, 240, 1, 1};
  Labels labels;
  std::vector<Vec3f> colors;
};

Lit domes(std::uint64_t seed, double shading, double uneven, bool gloss) {
  Lit s;
  Random random(seed);
  s.labels.width = 300;
  s.labels.height = 240;
  s.labels.sections = 1;
  s.labels.ids.assign(s.image.pixels.size(), 0);
  for (int k = 0; k < 20; ++k) {
    const auto l = static_cast<float>(random.uniform(0.15, 0.5));
    s.colors.push_back(
        l * Vec3f(1, static_cast<float>(random.uniform(0.7, 1)), static_cast<float>(random.uniform(0.5, 1))));
    s.labels.classes.push_back(0);
  }
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 300; ++x) {
      const int column = x / 60, row = y / 60, k = row * 5 + column;
      const double u = (x - 60 * column - 30) / 24.0, v = (y - 60 * row - 30) / 24.0, r2 = u * u + v * v;
      Vec3f c = Vec3f::Constant(0.3f);
      double light = 1;
      if (r2 < 1) {
        s.labels.ids[s.image.index(x, y, 0)] = k + 1;
        c = s.colors[k];
        light = 1 + shading * (0.6 * u - 0.3 * v + 0.8 * (std::sqrt(1 - r2) - 1));
        if (gloss && std::hypot(u - 0.3, v + 0.2) < 0.15) light *= 3;
      }
      light *= std::exp(uneven * (x - 150) / 150.0) * (1 + 0.03 * random.normal());
      s.image.at(x, y) = static_cast<float>(light) * c;
    }
  return s;
}

// Mean distance of measured from true colors, relative, after the best common factor.
double error_of(const Lit& s, bool how) {
  SegmentOptions options;
  options.delight = how;
  const Segmentation m = measure_labels(s.image, s.labels, options, {});
  double both = 0, square = 0, error = 0;
  for (std::size_t k = 0; k < s.colors.size(); ++k) {
    const Vec3f& c = m.profiles.profiles[k].color;
    both += c.dot(s.colors[k]);
    square += c.squaredNorm();
  }
  for (std::size_t k = 0; k < s.colors.size(); ++k)
    error +=
        (both / square * m.profiles.profiles[k].color.cast<double>() - s.colors[k].cast<double>()).norm() /
        s.colors[k].norm();
  return error / static_cast<double>(s.colors.size());
}

TEST(Delight, RecoversTheColorsOfDomesInUnevenLight) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Lit s = domes(seed, 0.6, 0.4, true);
    const double lit = error_of(s, false), even = error_of(s, true);

    EXPECT_GT(lit, 0.15);
    EXPECT_LT(even, 0.3 * lit);
  }
}

// What remains of the shading within the particles.
TEST(Delight, FlattensDomes) {
  const Lit s = domes(4, 0.6, 0, false);
  const Image even = delight(s.image, s.labels, {}, {});
  for (int k = 1; k <= s.labels.count(); ++k) {
    double sum[2] = {0, 0}, square[2] = {0, 0}, n = 0;
    for (std::size_t i = 0; i < s.labels.ids.size(); ++i)
      if (s.labels.ids[i] == k) {
        int j = 0;
        for (const Image* p : {&s.image, &even})
          sum[j] += p->pixels[i][1], square[j] += p->pixels[i][1] * p->pixels[i][1], ++j;
        ++n;
      }
    const auto variation = [&](int j) {
      return std::sqrt(square[j] / n - sum[j] * sum[j] / (n * n)) / (sum[j] / n);
    };
    EXPECT_LT(variation(1), 0.4 * variation(0)) << k;
  }
}

// A flat section in even light keeps its colors.
TEST(Delight, LeavesFlatSectionsAlone) {
  const Lit s = domes(5, 0, 0, false);
  const Image even = delight(s.image, s.labels, {}, {});
  for (std::size_t i = 0; i < even.pixels.size(); ++i)
    ASSERT_LT((even.pixels[i] - s.image.pixels[i]).norm(), 0.06f * s.image.pixels[i].norm()) << i;
}

// Of particles that are found in a photograph as well as of given labels.
TEST(Delight, ChangesTheColorsOfPhotographs) {
  synthetic_photo::PhotoOptions o;
  o.scene = synthetic_photo::Scene::Bank;
  o.seed = 900002;
  o.objects = false;
  o.fill = 0.4;
  const Value photo = Value::of(synthetic_photo::take_photo(o, {}).image);
  const auto measured = [&](const char* delight) {
    const auto run =
        test::run_node("Segment", {{"image", photo}}, {{"method", "network"}, {"delight", delight}});
    std::vector<Vec3f> colors;
    for (const auto& p : run.output<Profiles>("profiles").profiles) colors.push_back(p.color);
    return std::pair(colors, run.output<Image>("delit").pixels);
  };
  const auto on = measured("on"), off = measured("off");
  EXPECT_EQ(off.second, photo.as<Image>().pixels);
  EXPECT_NE(on.second, off.second);
  ASSERT_EQ(on.first.size(), off.first.size());
  EXPECT_NE(on.first, off.first);
  // Each keeps about its lightness.
  double sum = 0;
  for (std::size_t k = 0; k < on.first.size(); ++k)
    sum += static_cast<double>(on.first[k].sum() / off.first[k].sum()) / static_cast<double>(on.first.size());
  EXPECT_NEAR(sum, 1, 0.08);
}

}  // namespace
}  // namespace terrazzo
