#include "nodes/common/geometry/directions.h"

#include <gtest/gtest.h>

namespace terrazzo {
namespace {

// Of uniform rotations every entry of the matrix has mean 0 and mean square 1/3, and the trace, 1 + 2 cos of
// the angle, has mean 0 and mean square 1. All moments fail for Euler angles or a uniform angle about a
// random axis.
template <class Draw>
void expect_uniform(Draw&& draw) {
  constexpr int kCount = 40000;
  Mat3 mean = Mat3::Zero(), square = Mat3::Zero();
  double trace = 0, trace_square = 0;
  for (int i = 0; i < kCount; ++i) {
    Random r(7, 1, static_cast<std::uint64_t>(i));
    const Quat q = draw(r);
    EXPECT_NEAR(q.norm(), 1, 1e-12);
    const Mat3 m = q.toRotationMatrix();
    mean += m / kCount;
    square += m.cwiseAbs2() / kCount;
    trace += m.trace() / kCount;
    trace_square += m.trace() * m.trace() / kCount;
  }
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.015);
  EXPECT_LT((square - Mat3::Constant(1.0 / 3)).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_NEAR(trace, 0, 0.025);
  EXPECT_NEAR(trace_square, 1, 0.03);
}

TEST(Directions, RandomRotationsAreUniform) {
  expect_uniform(random_rotation);
  expect_uniform([](Random& r) { return random_quaternion(r).normalized(); });
}

// Results depend on the order in which the components are drawn.
TEST(Directions, AQuaternionIsDrawnFromItsEnd) {
  Random r(3), s(3);
  const Quat q = random_quaternion(r);
  for (const double c : {q.z(), q.y(), q.x(), q.w()}) EXPECT_EQ(c, s.normal());
}

TEST(Directions, RandomDirectionsAreUniform) {
  Vec3 mean = Vec3::Zero();
  Mat3 moments = Mat3::Zero();
  for (int i = 0; i < 40000; ++i) {
    Random r(5, 1, static_cast<std::uint64_t>(i));
    const Vec3 d = random_direction(r);
    mean += d / 40000;
    moments += d * d.transpose() / 40000;
  }
  EXPECT_LT(mean.norm(), 0.015);
  EXPECT_LT((moments - Mat3::Identity() / 3).cwiseAbs().maxCoeff(), 0.01);
}

}  // namespace
}  // namespace terrazzo
