#include "nodes/detail/detail_solid/isotropy.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

constexpr int kSize = 32;
float signed_frequency(int i) { return static_cast<float>(i <= kSize / 2 ? i : i - kSize); }

// Power of the frequencies within 30° of an axis and more than 60° off it, at distances from 4 to 14.
std::pair<double, double> power_along(const std::vector<LaneComplex>& data, const Vec3f& axis) {
  double along = 0, across = 0, n = 0, m = 0;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const Vec3f f(signed_frequency(static_cast<int>(i % kSize)),
                  signed_frequency(static_cast<int>(i / kSize % kSize)),
                  signed_frequency(static_cast<int>(i / kSize / kSize)));
    if (f.norm() < 4 || f.norm() > 14) continue;
    const float c = std::abs(f.normalized().dot(axis));
    const double p = data[i].re[0] * data[i].re[0] + data[i].im[0] * data[i].im[0];
    if (c > 0.866f) along += p, ++n;
    if (c < 0.5f) across += p, ++m;
  }
  return {along / n, across / m};
}

// The transform of strokes along a diagonal has little power along it.
std::vector<LaneComplex> strokes(const Vec3f& axis) {
  std::vector<LaneComplex> data(kSize * kSize * kSize);
  Random random(3);
  for (std::size_t i = 0; i < data.size(); ++i) {
    const Vec3f f(signed_frequency(static_cast<int>(i % kSize)),
                  signed_frequency(static_cast<int>(i / kSize % kSize)),
                  signed_frequency(static_cast<int>(i / kSize / kSize)));
    const float c = f.norm() > 0 ? f.normalized().dot(axis) : 0;
    const auto a = static_cast<float>(1 - 0.5 * c * c);
    const auto re = static_cast<float>(a * random.normal()), im = static_cast<float>(a * random.normal());
    data[i] = {Lane{re, re, re, 0}, Lane{im, im, im, 0}};
  }
  return data;
}

TEST(DetailIsotropy, StrokesAlongADiagonalGetShort) {
  const Vec3f axis = Vec3f(1, 1, 1).normalized();
  auto data = strokes(axis);
  const auto before = power_along(data, axis);
  ASSERT_LT(before.first / before.second, 0.45);
  equalize_directions(data, kSize);
  const auto after = power_along(data, axis);
  EXPECT_NEAR(after.first / after.second, 1, 0.3);
}

TEST(DetailIsotropy, AnyNumberOfThreadsGivesTheSame) {
  auto one = strokes(Vec3f::UnitX()), many = one;
  tbb::task_arena(1).execute([&] { equalize_directions(one, kSize); });
  tbb::task_arena(7).execute([&] { equalize_directions(many, kSize); });
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i].re[0], many[i].re[0]);
}

}  // namespace
}  // namespace terrazzo
