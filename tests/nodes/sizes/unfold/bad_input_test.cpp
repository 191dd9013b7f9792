// Input that cannot be unfolded.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "tests/nodes/sizes/unfold/spheres.h"
#include "tests/nodes/sizes/unfold/spheres_section.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace kmatrix;
using namespace unfolding;
using test::section;

TEST(Unfold, BadInputIsNamed) {
  const auto code = [](const Profiles& p, UnfoldOptions o = {}, const KMatrix* k = nullptr) {
    return test::code_of([&] { unfolding::unfold(p, k ? *k : test::spheres<10>(), o, {}); });
  };
  const Profiles good = section(5, 10, 0.001, 1e5, 3);
  EXPECT_EQ(code(good), "");
  EXPECT_EQ(code(Profiles()), "no-profiles");
  Profiles p = good;
  p.profiles[3].area = std::nan("");
  EXPECT_EQ(code(p), "bad-profiles");
  p = good;
  p.profiles[3].area = 0;
  EXPECT_EQ(code(p), "bad-profiles");
  p = good;
  for (auto& q : p.profiles) q.weight = 0;
  EXPECT_EQ(code(p), "no-profiles");
  p = good;
  p.profiles.resize(1);
  EXPECT_EQ(code(p), "too-few-profiles");
  EXPECT_EQ(code(good, {.smallest_visible = 100}), "no-profiles");
  EXPECT_EQ(code(good, {.d_max = 1}), "too-small");
  KMatrix empty = test::spheres<10>();
  empty.shapes.clear();
  EXPECT_EQ(code(good, {}, &empty), "bad-kmatrix");
  // A body whose sections are almost invisible: its K matrix has empty columns or is singular.
  KMatrix blind = test::spheres<10>();
  std::fill(blind.shapes[0].cdf.begin(), blind.shapes[0].cdf.end(), 1.0);
  for (const auto method : {unfolding::Method::Em, unfolding::Method::Nnls, unfolding::Method::Inverse})
    EXPECT_EQ(code(good, {.method = method, .smallest_visible = 2}, &blind), "bad-kmatrix")
        << static_cast<int>(method);
  EXPECT_EQ(code(good, {.method = unfolding::Method::Inverse, .smallest_visible = 0, .d_max = 12}, &blind),
            "singular");
  // The number of classes of the K matrix does not matter: the result equals that of a matrix
  // with the requested classes.
  const auto solved = [&](int classes) {
    const auto ball = test::run_node("Shape", {}, {{"kind", "sphere"}, {"size", "1"}}).outputs.at("shapes");
    const KMatrix k =
        make_kmatrix(ball.as<Shapes>(), {.method = kmatrix::Method::Analytic, .classes = classes});
    return unfolding::unfold(good, k, {.method = unfolding::Method::Nnls, .classes = 8, .d_max = 12}, {})
        .distribution.shapes[0]
        .N_V;
  };
  EXPECT_EQ(solved(5), solved(8));
  Profiles equal = good;
  for (auto& q : equal.profiles) q.area = 10;
  EXPECT_EQ(code(equal), "");
}

TEST(Unfold, WhatCannotFillAVolumeIsRefused) {
  // The inverse for angular bodies amplifies counting errors by orders of magnitude.
  const auto solid =
      test::run_node("Shape", {}, {{"kind", "octahedron"}, {"size", "1"}}).outputs.at("shapes");
  const KMatrix k = make_kmatrix(solid.as<Shapes>(), {.classes = 14, .orientations = 500});
  UnfoldOptions o;
  o.method = unfolding::Method::Inverse;
  o.d_max = 12;
  o.smallest_visible = 0;
  try {
    unfolding::unfold(section(2, 10, 0.001, 3e4, 4), k, o, {});
    FAIL() << "a density of particles that do not fit";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "unstable") << e.what();
    EXPECT_EQ(e.diagnostic().parameter, "classes");
  }
  for (const auto method : {unfolding::Method::Nnls, unfolding::Method::Em}) {
    o.method = method;
    const UnfoldResult r = unfolding::unfold(section(2, 10, 0.001, 3e4, 4), k, o, {});
    EXPECT_LT(r.distribution.volume_fraction, 1);
  }
}

}  // namespace
}  // namespace terrazzo
