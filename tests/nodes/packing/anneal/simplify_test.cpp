// The simplified meshes that the contact search uses.
#include "nodes/packing/rigid/simplify.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/packing/rigid/contact/contact_shape.h"
#include "tests/nodes/packing/anneal/brute_force.h"

namespace terrazzo {
namespace {

using namespace packing;

Mesh dented(int levels) {
  return test::warped(test::icosphere(levels), [](const Vec3& p) {
    return Vec3(p.cwiseProduct(Vec3(1.3, 1, 0.8)) *
                (1 + 0.1 * std::sin(6 * p[0]) * std::sin(5 * p[1] + p[2])));
  });
}

TEST(AnnealSimplify, StaysWithinTheTolerance) {
  const Mesh mesh = dented(5);
  const Simplified simple = simplified(mesh, 0.01);
  EXPECT_LE(simple.mesh.triangles.size(), mesh.triangles.size() / 2);
  EXPECT_TRUE(mesh_faults(simple.mesh).empty());
  const MeshDistance to_simple(simple.mesh), to_mesh(mesh);
  double farthest = 0;
  for (const Vec3& v : mesh.vertices) farthest = std::max(farthest, std::abs(to_simple.signed_distance(v)));
  for (const Vec3& v : simple.mesh.vertices)
    farthest = std::max(farthest, std::abs(to_mesh.signed_distance(v)));
  EXPECT_GT(farthest, 0);
  EXPECT_LE(farthest, 0.01);
  EXPECT_LE(farthest, simple.deviation + 1e-12);
}

TEST(AnnealSimplify, KeepsWhatCannotBeSimplified) {
  const Mesh small = dented(3);
  EXPECT_EQ(simplified(small, 0.01).mesh.triangles, small.triangles);
  const Mesh mesh = dented(5);
  EXPECT_EQ(simplified(mesh, 1e-9).mesh.triangles, mesh.triangles);
}

TEST(AnnealSimplify, ContactShapesOfFineMeshesHaveFewElements) {
  const ContactShape fine = make_contact_shape(dented(5));
  EXPECT_LT(fine.tree(ContactDetail::All).elements.size(), 2500u);
  EXPECT_GT(fine.bounding_radius, 1.2);
  EXPECT_LT(fine.error, 0.005);
}

}  // namespace
}  // namespace terrazzo
