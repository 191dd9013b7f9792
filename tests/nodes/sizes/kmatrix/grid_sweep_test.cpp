#include "nodes/sizes/kmatrix/grid_sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/sizes/kmatrix/section_statistics.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace shape;
using namespace kmatrix;

TEST(GridSweep, AreasAreThoseOfExactSections) {
  Mesh mesh = ellipsoid_mesh({1, .8, .6}, 3);
  transform(mesh, Mat3::Identity(), {30, -20, 10});
  GridSweep sweep(mesh);
  for (std::uint64_t i = 0; i < 20; ++i) {
    Random random(4, 0, i);
    const Vec3 u = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    Mat3 frame;
    frame.col(0) = u.unitOrthogonal(), frame.col(2) = u, frame.col(1) = u.cross(frame.col(0));
    double z = 1e300;
    for (const Vec3& v : mesh.vertices) z = std::min(z, u.dot(v));
    double volume = 0;
    for (const AreaRange& r : sweep.sweep(u)) {
      for (const auto& [at, area] : {std::pair(0.5, r.middle), std::pair(1.0, r.high)}) {
        double exact = 0;
        for (const auto& loop : section_loops(mesh, frame, z + at * r.thickness)) exact += loop_area(loop);
        EXPECT_NEAR(area, exact, 1e-6);
      }
      volume += r.thickness * (r.low + 4 * r.middle + r.high) / 6;
      z += r.thickness;
    }
    EXPECT_NEAR(volume / mesh_volume(mesh), 1, 2e-3);
  }
}

// A cube whose faces are subdivided into many triangles is cut at chosen depths, the plain
// cube at all depths.
TEST(GridSweep, ManyTrianglesGiveTheStatisticsOfFew) {
  const Mesh few = box_mesh({1, 1, 1});
  Mesh many = few;
  for (int level = 0; level < 4; ++level) {
    std::vector<Triangle> next;
    std::map<std::pair<int, int>, int> half;
    const auto middle = [&](int a, int b) {
      const auto [it, added] = half.try_emplace(std::minmax(a, b), static_cast<int>(many.vertices.size()));
      if (added) many.vertices.push_back((many.vertices[a] + many.vertices[b]) / 2);
      return it->second;
    };
    for (const Triangle& t : many.triangles) {
      const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      next.insert(next.end(),
                  {Triangle{t[0], a, c}, Triangle{t[1], b, a}, Triangle{t[2], c, b}, Triangle{a, b, c}});
    }
    many.triangles = std::move(next);
  }
  ASSERT_EQ(many.triangles.size(), 3072u);
  const SectionStatistics coarse = slice_statistics(measure_shape("cube", few), 10, 0);
  const SectionStatistics fine = slice_statistics(measure_shape("cube", many), 10, 0);
  EXPECT_LE(fine.residual, 4e-3);
  for (int k = 0; k < 10; ++k) {
    const auto share = [&](const SectionStatistics& s) {
      return s.cdf[(k + 1) * 100 - 1] - (k > 0 ? s.cdf[k * 100 - 1] : 0);
    };
    EXPECT_NEAR(share(fine) / share(coarse), 1, 5e-3) << k;
  }
}

}  // namespace
}  // namespace terrazzo
