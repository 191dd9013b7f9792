// Reference values and identities of stereology (Underwood 1970; Jagnow et al. 2004, eq. 1), compared with
// slicing at its default effort.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "nodes/common/geometry/mesh/convex_hull.h"
#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/common/stereology/profile_sweep.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/common/stereology/size_kernel.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "tests/nodes/bodies/section/packing.h"

namespace terrazzo {
namespace {
using namespace shape;
using namespace kmatrix;

using std::numbers::pi;

constexpr double kWithin = 1e-3;  // relative

// Quasi-random directions on the half sphere (Roberts 2018).
Vec3 direction(int i) {
  const double z = std::fmod(0.5 + 0.7548776662466927 * (i + 1), 1.0);
  const double phi = 2 * pi * std::fmod(0.5 + 0.5698402909980532 * (i + 1), 1.0);
  return {std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z};
}

Mesh truncated_octahedron() {
  std::vector<Vec3> points;
  for (int zero = 0; zero < 3; ++zero)
    for (int signs = 0; signs < 4; ++signs)
      for (int swapped = 0; swapped < 2; ++swapped) {
        Vec3 p = Vec3::Zero();
        p[(zero + 1) % 3] = (signs & 1 ? -1 : 1) * (swapped ? 2 : 1) / std::sqrt(2.0);
        p[(zero + 2) % 3] = (signs & 2 ? -1 : 1) * (swapped ? 1 : 2) / std::sqrt(2.0);
        points.push_back(p);
      }
  return convex_hull(points);
}

struct Body {
  const char* name;
  Mesh mesh;
  double caliper, largest;  // 0: not tabulated
};

// Curved bodies have 20,480 triangles: with fewer, the tessellation error would exceed 1e-3.
std::vector<Body> bodies() {
  return {{"sphere", ellipsoid_mesh({1, 1, 1}, 5), 1, pi / 4},
          {"prolate", ellipsoid_mesh({2, 2, 4}, 5), 2.7603460, 2 * pi},
          {"oblate", ellipsoid_mesh({4, 4, 2}, 5), 3.4183992, 4 * pi},
          {"ellipsoid", ellipsoid_mesh({2, 1.6, 1.2}, 5), 1.6200600, 0.8 * pi},
          {"cube", box_mesh({1, 1, 1}), 1.5, std::sqrt(2.0)},
          {"box", box_mesh({1, 2, 3}), 3, 3 * std::sqrt(5.0)},
          {"tetrahedron", platonic_mesh(SolidKind::Tetrahedron), .9122602, std::sqrt(3.0) / 4},
          {"octahedron", platonic_mesh(SolidKind::Octahedron), 1.1754797, 1},
          {"dodecahedron", platonic_mesh(SolidKind::Dodecahedron), 2.6431229, 0},
          {"icosahedron", platonic_mesh(SolidKind::Icosahedron), 1.7420965, 0},
          {"truncated octahedron", truncated_octahedron(), 3, 0},
          {"cylinder", cylinder_mesh({1, 1, 2}, 4), 1 + pi / 4, 2}};
}

TEST(KMatrixReference, CalipersLargestSectionsAndMeanAreas) {
  for (const Body& b : bodies()) {
    Shapes one;
    one.shapes.push_back(measure_shape(b.name, b.mesh));
    const auto e = make_kmatrix(one, {.averaging = "upper_edge"}).shapes[0];
    EXPECT_NEAR(e.mean_caliper / b.caliper, 1, kWithin) << b.name;
    if (b.largest > 0) {
      EXPECT_NEAR(e.max_section_area / b.largest, 1, kWithin) << b.name;
    }
    EXPECT_NEAR(mean_relative_area(e.cdf) * e.max_section_area / (e.volume / e.mean_caliper), 1, kWithin)
        << b.name;
    EXPECT_NEAR(e.K.col(9).sum(), 1, 1e-9) << b.name;
  }
}

// Number of corners of a convex outline, ignoring the collinear vertices from a triangulated face.
int corners(const std::vector<Vec2>& loop) {
  int n = 0;
  const std::size_t size = loop.size();
  for (std::size_t i = 0; i < size; ++i) {
    const Vec2 a = loop[i] - loop[(i + size - 1) % size], b = loop[(i + 1) % size] - loop[i];
    n += std::abs(a.x() * b.y() - a.y() * b.x()) > 1e-9 * (a.norm() * b.norm() + 1e-9);
  }
  return n;
}

// Between two vertices the outline's length is linear in the depth and the number of its sides constant, so
// the middle represents the whole range.
TEST(KMatrixReference, PerimetersAndSidesOfPolyhedra) {
  const double edges[] = {12, 6};
  const Mesh solids[] = {box_mesh({1, 1, 1}), platonic_mesh(SolidKind::Tetrahedron)};
  for (int s = 0; s < 2; ++s) {
    const Shape shape = measure_shape("solid", solids[s]);
    double depth = 0, perimeter = 0, sides = 0;
    std::map<int, double> by_sides;
    for (int i = 0; i < 12000; ++i) {
      const Vec3 u = direction(i);
      Mat3 frame;
      frame.col(2) = u, frame.col(0) = u.unitOrthogonal(), frame.col(1) = u.cross(frame.col(0));
      std::vector<double> heights;
      for (const Vec3& v : shape.mesh.vertices) heights.push_back(u.dot(v));
      std::sort(heights.begin(), heights.end());
      for (std::size_t k = 0; k + 1 < heights.size(); ++k) {
        const double thickness = heights[k + 1] - heights[k];
        if (thickness < 1e-7) continue;
        for (const auto& loop : section_loops(shape.mesh, frame, (heights[k] + heights[k + 1]) / 2)) {
          for (std::size_t j = 0; j < loop.size(); ++j)
            perimeter += thickness * (loop[(j + 1) % loop.size()] - loop[j]).norm();
          const int n = corners(loop);
          by_sides[n] += thickness;
          sides += n * thickness;
          depth += thickness;
        }
      }
    }
    EXPECT_NEAR(depth / 12000 / shape.mean_caliper, 1, kWithin);
    EXPECT_NEAR(perimeter / depth / (pi * shape.surface_area / (4 * shape.mean_caliper)), 1, kWithin);
    EXPECT_NEAR(sides / depth / (edges[s] / (2 * shape.mean_caliper)), 1, kWithin);
    if (s > 0) continue;
    const std::map<int, double> cube{{3, .279826}, {4, .486796}, {5, .186931}, {6, .046448}};
    for (const auto& [n, share] : cube) EXPECT_NEAR(by_sides[n] / depth, share, kWithin * 0.5) << n;
  }
}

// The mean over directions of ∫χ dh is (1/4π) Σ L·θ, with concave edges negative (the χ identity
// in docs/validation.md). The body is a ring, whose sections are one region, two regions, or
// one with a hole.
TEST(KMatrixReference, EulerNumbersOfBodiesThatAreNotConvex) {
  const Mesh ring = test::square_ring().mesh;
  ProfileSweep sweep(ring);
  double sum = 0;
  constexpr int kDirections = 20000;
  for (int i = 0; i < kDirections; ++i)
    for (const ProfileRange& p : sweep.sweep(direction(i))) sum += p.area.thickness * (1 - p.holes);
  EXPECT_NEAR(sum / kDirections / mesh_edge_curvature(ring), 1, kWithin);
}

}  // namespace
}  // namespace terrazzo
