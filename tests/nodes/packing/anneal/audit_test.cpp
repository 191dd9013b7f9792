#include <gtest/gtest.h>

#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/packing/rigid/audit.h"
#include "nodes/packing/rigid/contact/polytope_contact.h"
#include "nodes/packing/rigid/contact/triangle_overlap.h"
#include "nodes/packing/rigid/neighbors.h"
#include "runtime/random.h"
#include "tests/nodes/packing/anneal/brute_force.h"

namespace terrazzo {
namespace {

using packing::audit;

Particles two(const Vec3& box, const Vec3& a, const Vec3& b, double scale = 1) {
  Particles p;
  p.box = box;
  p.resize(2);
  p.position = {a, b};
  p.scale = p.size = {scale, scale};
  return p;
}

TEST(AnnealAudit, CubesAtKnownDepths) {
  const auto shapes = test::shapes_of({test::cube()});
  const Vec3 box(10, 10, 10);
  EXPECT_EQ(audit(shapes, two(box, {5, 5, 5}, {6.001, 5, 5})).found.size(), 0u);
  auto p = two(box, {5, 5, 5}, {5.99, 5.2, 5.3});
  auto found = audit(shapes, p);
  ASSERT_EQ(found.found.size(), 1u);
  EXPECT_NEAR(found.found[0].depth, 0.01, 1e-9);
  p.size = {2, 0.5};
  EXPECT_NEAR(audit(shapes, p).worst, 0.02, 1e-9);
}

TEST(AnnealAudit, SeesAcrossEveryFaceOfTheBox) {
  const auto shapes = test::shapes_of({test::cube()});
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 a(2, 2, 2), b(2, 2, 2);
    a[axis] = 0.2;
    b[axis] = 3.3;
    EXPECT_NEAR(audit(shapes, two(Vec3(4, 4, 4), a, b)).worst, 0.1, 1e-9);
    b[axis] = 3.1;
    EXPECT_EQ(audit(shapes, two(Vec3(4, 4, 4), a, b)).worst, 0);
  }
}

TEST(AnnealAudit, CrossedEdgesWithoutAVertexInside) {
  const auto shapes = test::shapes_of({test::cube()});
  Particles p = two(Vec3(20, 20, 20), {10, 10, 10}, {10, 10, 10});
  const double half = std::sqrt(0.5);
  p.orientation[0] = Quat(Eigen::AngleAxisd(M_PI / 4, Vec3::UnitX()));
  p.orientation[1] = Quat(Eigen::AngleAxisd(M_PI / 4, Vec3::UnitY()));
  p.position[1][2] += 2 * half + 1e-3;  // edges along x and y, crossing at right angles
  EXPECT_EQ(audit(shapes, p).worst, 0);
  p.position[1][2] -= 2e-3;
  EXPECT_NEAR(audit(shapes, p).worst, 1e-3, 1e-6);
}

TEST(AnnealAudit, OneInsideTheOther) {
  const auto shapes = test::shapes_of({test::icosphere(2)});
  Particles p = two(Vec3(20, 20, 20), {10, 10, 10}, {10.2, 10, 10});
  p.scale[1] = 0.1;
  EXPECT_GT(audit(shapes, p).worst, 0.5);
}

TEST(AnnealAudit, AgreesWithBruteForce) {
  const auto shapes = test::shapes_of({test::peanut(1), test::angle(), test::tetrahedron()});
  int overlapping = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Random random(3, 0, trial);
    Particles p = two(Vec3(12, 12, 12), {6, 6, 6}, {6, 6, 6});
    for (int k = 0; k < 2; ++k) {
      p.shape[k] = static_cast<int>(random.below(3));
      p.orientation[k] =
          Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
      p.scale[k] = random.uniform(0.5, 1.5);
    }
    p.position[1] +=
        2.2 * random.uniform() * Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const bool found = !audit(shapes, p).found.empty();
    EXPECT_EQ(found, test::brute::overlaps(shapes, p) > 0) << "trial " << trial;
    overlapping += found;
  }
  EXPECT_GT(overlapping, 50);
  EXPECT_LT(overlapping, 250);
}

TEST(AnnealAudit, TrianglePenetration) {
  const packing::Corners flat{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const auto spike = [](double tip) {
    return packing::Corners{Vec3(.2, .2, tip), Vec3(.2, .3, 1), Vec3(.3, .2, 1)};
  };
  EXPECT_EQ(packing::triangle_penetration(flat, spike(0.01)), -1);
  EXPECT_EQ(packing::triangle_penetration(flat, spike(0)), 0);
  EXPECT_NEAR(packing::triangle_penetration(flat, spike(-0.01)), 0.01, 1e-12);
  const packing::Corners beside{Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(2, 1, 0)};
  EXPECT_EQ(packing::triangle_penetration(flat, beside), -1);
}

TEST(AnnealAudit, DistancesBelowTheGap) {
  const auto shapes = test::shapes_of({test::cube()});
  const Vec3 box(10, 10, 10);
  const auto faces = two(box, {5, 5, 5}, {6.1, 5.3, 5.2});  // 0.1 apart
  EXPECT_EQ(audit(shapes, faces, 0.099).worst, 0);
  EXPECT_NEAR(audit(shapes, faces, 0.3).found.at(0).depth, 0.2, 1e-9);
  auto corners = two(box, {5, 5, 5}, {6.1, 6.2, 6.2});  // corner to corner
  EXPECT_NEAR(audit(shapes, corners, 0.4).found.at(0).depth, 0.4 - 0.3, 1e-9);
  EXPECT_EQ(audit(shapes, corners, 0.29).worst, 0);
  EXPECT_NEAR(audit(shapes, two(box, {5, 5, 5}, {5.9, 5.2, 5.1}), 0.3).worst * 1.0, (0.3 + 0.1) / 1.0, 1e-9);
}

// Compares the separating axis test with the exact one, for polyhedra of all orientations and depths.
TEST(AnnealContact, PolyhedraAgreeWithTheAudit) {
  const auto shapes = test::shapes_of({test::cube(), test::tetrahedron()});
  packing::Polytope polytopes[2] = {packing::make_polytope(shapes.shapes[0].mesh, 40),
                                    packing::make_polytope(shapes.shapes[1].mesh, 40)};
  EXPECT_EQ(polytopes[0].faces.size(), 6u);
  EXPECT_EQ(polytopes[0].edges.size(), 12u);
  EXPECT_EQ(polytopes[1].edges.size(), 6u);
  EXPECT_TRUE(packing::make_polytope(test::angle(), 40).empty());
  int overlapping = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Random random(5, 0, trial);
    Particles p = two(Vec3(20, 20, 20), {10, 10, 10}, {10, 10, 10});
    packing::PlacedPolytope bodies[2];
    for (int k = 0; k < 2; ++k) {
      p.shape[k] = static_cast<int>(random.below(2));
      p.orientation[k] =
          Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
      p.scale[k] = random.uniform(0.5, 1.5);
      bodies[k] = {&polytopes[p.shape[k]], p.orientation[k].toRotationMatrix().cast<float>(),
                   static_cast<float>(p.scale[k])};
    }
    const Vec3 offset =
        3 * random.uniform() * Vec3(random.normal(), random.normal(), random.normal()).normalized();
    p.position[1] += offset;
    Vec3f hint = Vec3f::Zero();
    packing::Manifold m;
    packing::find_manifold(bodies[0], bodies[1], offset.cast<float>(), 0, hint, m);
    if (std::abs(m.separation) < 1e-4) continue;
    const bool overlap = audit(shapes, p).worst > 0;
    EXPECT_EQ(m.separation < 0, overlap) << "trial " << trial;
    overlapping += overlap;
    if (!overlap) continue;
    // Moved apart along the axis by the depth, they are free; by slightly less, they are not.
    p.position[1] += m.normal.cast<double>() * (1e-4 - m.separation);
    EXPECT_EQ(audit(shapes, p).worst, 0) << "trial " << trial;
    EXPECT_GT(m.count, 0);
  }
  EXPECT_GT(overlapping, 80);
}

TEST(AnnealAudit, SignedDistanceOfACube) {
  const Mesh mesh = test::cube();  // [0, 1]³
  const MeshDistance distance(mesh);
  for (int trial = 0; trial < 500; ++trial) {
    Random random(1, 0, trial);
    const Vec3 p(random.uniform(-1, 2), random.uniform(-1, 2), random.uniform(-1, 2));
    const Vec3 q = (p - Vec3::Constant(0.5)).cwiseAbs() - Vec3::Constant(0.5);
    const double exact = q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    EXPECT_NEAR(distance.signed_distance(p), exact, 1e-9);
  }
}

TEST(AnnealNeighbors, FindsAllPairsOfMixedSizes) {
  for (int trial = 0; trial < 6; ++trial) {
    Random random(2, 0, trial);
    const Vec3 box(3 + 4 * random.uniform(), 3, 5);
    std::vector<Vec3> position;
    std::vector<double> radius;
    for (int i = 0; i < 120; ++i) {
      position.push_back(Vec3(random.uniform(), random.uniform(), random.uniform()).cwiseProduct(box));
      radius.push_back(1.4 * std::pow(0.02, random.uniform()));
    }
    int expected = 0;
    for (int i = 0; i < 120; ++i)
      for (int j = i + 1; j < 120; ++j)
        for (int n = 0; n < 27; ++n) {
          const Vec3 shift = Vec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1).cwiseProduct(box);
          expected += (position[j] + shift - position[i]).norm() < radius[i] + radius[j] + 0.05;
        }
    EXPECT_EQ(static_cast<int>(packing::near_pairs(box, position, radius, 0.05).size()), expected);
  }
}

// The second audit tests only the pairs of particles that moved, and finds the same.
TEST(AnnealAudit, RemembersThePairsThatDidNotMove) {
  const auto shapes = test::shapes_of({test::cube(), test::peanut(2)});
  Particles p;
  p.box = Vec3::Constant(6);
  p.resize(60);
  for (std::size_t i = 0; i < p.count(); ++i) {
    Random r(1, 2, i);
    p.shape[i] = static_cast<std::int32_t>(i % 2);
    p.position[i] = Vec3(r.uniform(), r.uniform(), r.uniform()) * 6;
    p.orientation[i] = Quat(r.normal(), r.normal(), r.normal(), r.normal()).normalized();
    p.scale[i] = 1;
    p.size[i] = shapes.shapes[p.shape[i]].size();
  }
  packing::Auditor auditor(shapes);
  const auto first = auditor(p);
  ASSERT_GT(first.found.size(), 20u);
  const auto expect_equal = [](const packing::AuditResult& a, const packing::AuditResult& b) {
    ASSERT_EQ(a.found.size(), b.found.size());
    for (std::size_t k = 0; k < a.found.size(); ++k) {
      EXPECT_EQ(a.found[k].a, b.found[k].a);
      EXPECT_EQ(a.found[k].b, b.found[k].b);
      EXPECT_EQ(a.found[k].depth, b.found[k].depth);
    }
    EXPECT_EQ(a.worst, b.worst);
    EXPECT_EQ(a.pairs, b.pairs);
  };
  const auto again = auditor(p);
  expect_equal(again, first);
  EXPECT_EQ(again.tests, 0u);
  for (const std::size_t i : {3, 17, 40}) p.position[i][0] = std::fmod(p.position[i][0] + 0.3, 6);
  p.scale[20] *= 0.9;
  p.size[20] *= 0.9;
  const auto moved = auditor(p);
  expect_equal(moved, packing::audit(shapes, p));
  EXPECT_LT(moved.tests, first.tests / 2);
  expect_equal(auditor(p, 0.1), packing::audit(shapes, p, 0.1));
}

}  // namespace
}  // namespace terrazzo
