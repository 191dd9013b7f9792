#include "nodes/photograph/grain/grain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace grain;

TEST(Grain, KeepsTheMeanAndHasTheNoiseAsked) {
  const Image in(200, 200, 1, 0.1, Vec3f::Constant(0.5f));
  GrainOptions g{0, 0, 1, 0, 0.02, 7};
  const Image out = add_grain(in, nullptr, g, {});
  double sum = 0, squares = 0;
  for (const auto& p : out.pixels) {
    sum += p[1];
    squares += p[1] * p[1];
  }
  const double n = static_cast<double>(out.pixels.size()), mean = sum / n,
               sd = std::sqrt(squares / n - mean * mean);
  EXPECT_NEAR(mean, 0.5, 5e-4);
  EXPECT_NEAR(sd, 0.02, 5e-4);
  g = {0.2, 0, 1, 0, 0, 7};
  const Image mottled = add_grain(in, nullptr, g, {});
  sum = squares = 0;
  for (const auto& p : mottled.pixels) {
    sum += p[1];
    squares += p[1] * p[1];
  }
  EXPECT_NEAR(std::sqrt(squares / n - sum / n * sum / n) / 0.5, 0.2, 0.06);
}

TEST(Grain, EachLabelHasItsOwnPattern) {
  const Image in(64, 64, 1, 0.1, Vec3f::Constant(0.5f));
  Labels labels{64, 64, 1, 0.1, std::vector<std::int32_t>(64 * 64, 1), {0, 0}};
  const GrainOptions g{0.2, 0.1, 1, 0, 0, 7};
  const Image one = add_grain(in, &labels, g, {});
  labels.ids[0] = 2;
  const Image other = add_grain(in, &labels, g, {});
  EXPECT_NE(one.pixels[0], other.pixels[0]);
  EXPECT_EQ(one.pixels[1], other.pixels[1]);
}

TEST(Grain, SameSeedSameBitsOnAnyNumberOfThreads) {
  const Value in = Value::of(Image(90, 70, 2, 0.1, Vec3f(0.2f, 0.4f, 0.6f)));
  const auto at = [&](int threads, const std::string& seed) {
    return test::run_node("Grain", {{"image", in}}, {{"seed", seed}}, {}, threads)
        .output<Image>("image")
        .pixels;
  };
  EXPECT_EQ(at(1, "3"), at(3, "3"));
  EXPECT_NE(at(1, "3"), at(1, "4"));
}

TEST(Grain, RefusesWhatDoesNotFit) {
  EXPECT_THROW(add_grain(Image(), nullptr, {}, {}), Error);
  const Labels labels{3, 3, 1, 1, std::vector<std::int32_t>(9, 0), {}};
  EXPECT_THROW(add_grain(Image(4, 3, 1, 1), &labels, {}, {}), Error);
}

}  // namespace
}  // namespace terrazzo
