#include "nodes/packing/rigid/contact/contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/nodes/packing/anneal/brute_force.h"

namespace terrazzo {
namespace {

using namespace packing;

// A cylinder along x with 48 sides: no edge is sharp, and rows of vertices run along the straight sides.
Mesh cylinder(double radius, double length) {
  constexpr int kSides = 48, kRings = 40;
  Mesh m;
  for (int r = 0; r <= kRings; ++r)
    for (int s = 0; s < kSides; ++s) {
      const double t = 2 * std::numbers::pi * s / kSides;
      m.vertices.emplace_back(length * (static_cast<double>(r) / kRings - 0.5), radius * std::cos(t),
                              radius * std::sin(t));
    }
  const auto at = [](int r, int s) { return r * kSides + s % kSides; };
  for (int r = 0; r < kRings; ++r)
    for (int s = 0; s < kSides; ++s) {
      m.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s + 1)});
      m.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r + 1, s)});
    }
  for (const int end : {0, kRings}) {
    const int center = static_cast<int>(m.vertices.size());
    m.vertices.emplace_back(length * (end == 0 ? -0.5 : 0.5), 0, 0);
    for (int s = 0; s < kSides; ++s) {
      if (end == 0)
        m.triangles.push_back({at(end, s + 1), at(end, s), center});
      else
        m.triangles.push_back({at(end, s), at(end, s + 1), center});
    }
  }
  return m;
}

float depth(const ContactShape& shape, const Eigen::Matrix3f& turn, const Vec3f& offset,
            ContactDetail detail) {
  const Body a{&shape, Eigen::Matrix3f::Identity(), 1}, b{&shape, turn, 1};
  ContactCandidates candidates;
  return find_contact(a, b, offset, 0, detail, candidates, 0.01f).depth;
}

TEST(AnnealContact, RoundedRidgesThatCrossAreSeenInFullDetail) {
  const ContactShape shape = make_contact_shape(cylinder(0.2, 2));
  ASSERT_GT(shape.tree(ContactDetail::All).elements.size(), shape.tree(ContactDetail::Fine).elements.size());
  const Eigen::Matrix3f crossed =
      Eigen::AngleAxisf(static_cast<float>(M_PI) / 2, Vec3f::UnitZ()).toRotationMatrix();
  int missed = 0;
  for (float x = -0.6f; x < 0.6f; x += 0.07f)
    for (float y = -0.5f; y < 0.5f; y += 0.13f) {
      const Vec3f offset(x, y, 0.38f);
      EXPECT_NEAR(depth(shape, crossed, offset, ContactDetail::All), 0.02, 0.004) << x << ' ' << y;
      EXPECT_EQ(depth(shape, crossed, offset + Vec3f(0, 0, 0.03f), ContactDetail::All), 0);
      missed += depth(shape, crossed, offset, ContactDetail::Fine) < 0.01f;
    }
  EXPECT_GT(missed, 0);  // points for flat contacts are not sufficient
}

}  // namespace
}  // namespace terrazzo
