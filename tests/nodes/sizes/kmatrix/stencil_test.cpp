// The paper's slicing method, on Mesa's software renderer. Skipped if that is not available.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/sizes/kmatrix/section_statistics.h"
#include "nodes/sizes/kmatrix/stencil_slicer.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace shape;
using namespace kmatrix;

class Stencil : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      EglContext context(GlDevice::Cpu);
    } catch (const Error& e) {
      GTEST_SKIP() << e.what();
    }
  }
};

TEST_F(Stencil, PixelsAgreeWithExactSections) {
  for (const Shape& s : {measure_shape("cube", box_mesh({1, 1, 1})),
                         measure_shape("ball", ellipsoid_mesh(Vec3(1, 0.7, 0.5), 3))}) {
    StencilSlicer slicer(s.mesh, GlDevice::Cpu);
    std::vector<SlicePlane> planes;
    const double reach = 0.4 * mesh_bounding_radius(s.mesh);
    for (std::uint64_t i = 0; i < 20; ++i) {
      Random random(5, 0, i);
      const Quat q = Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
      planes.push_back({q, random.uniform(-reach, reach)});
    }
    slicer.draw(planes);
    for (int i = 0; i < 20; ++i) {
      double exact = 0, perimeter = 0;
      // Columns: the vectors that are rotated to x, y, z.
      const Mat3 rows = planes[i].rotation.toRotationMatrix().transpose();
      for (const auto& loop : section_loops(s.mesh, rows, planes[i].depth))
        exact += loop_area(loop), perimeter += loop_perimeter(loop);
      std::int64_t inside = 0;
      for (int y = 0; y < StencilSlicer::kTile; ++y)
        for (int w = 0; w < StencilSlicer::kTile / 32; ++w) inside += std::popcount(slicer.row(i, y)[w]);
      // An outline crosses about perimeter / pixel size pixels, each half right on average. The errors add up
      // as a random walk, and along edges parallel to the rows coherently.
      EXPECT_NEAR(static_cast<double>(inside) * slicer.pixel_area(), exact,
                  0.5 * perimeter * std::sqrt(slicer.pixel_area()))
          << s.name << ' ' << i;
    }
  }
}

TEST_F(Stencil, MeetsTheSliceMethodWithinItsSamplingError) {
  const Shape cube = measure_shape("cube", box_mesh({1, 1, 1}));
  const SectionStatistics exact = slice_statistics(cube, 10, 4000);
  constexpr std::size_t kSlices = 4096;
  const SectionStatistics seen = stencil_statistics(cube, 10, kSlices, GlDevice::Cpu);
  EXPECT_EQ(seen.profiles_per_caliper, 1);
  EXPECT_EQ(seen.orientations, kSlices);
  for (int k = 0; k < 10; ++k) {
    const auto share = [&](const SectionStatistics& s) {
      return s.cdf[(k + 1) * 100 - 1] - (k > 0 ? s.cdf[k * 100 - 1] : 0);
    };
    const double p = share(exact);
    EXPECT_NEAR(share(seen), p, 3 * std::sqrt(p * (1 - p) / kSlices)) << k;
  }
}

TEST_F(Stencil, DisjointProfilesCountApart) {
  // Two balls far apart: a plane that meets the hull meets one of them, both, or neither.
  Mesh two = ellipsoid_mesh(Vec3(1, 1, 1), 2);
  const auto first = static_cast<std::int32_t>(two.vertices.size());
  const Mesh other = two;
  for (auto& v : two.vertices) v.x() -= 2;
  for (const Vec3& v : other.vertices) two.vertices.push_back(v + Vec3(2, 0, 0));
  for (const Triangle& t : other.triangles)
    two.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  const Shape s = measure_shape("two", two);
  const SectionStatistics exact = slice_statistics(s, 5, 500);
  const SectionStatistics seen = stencil_statistics(s, 5, 2048, GlDevice::Cpu);
  EXPECT_NEAR(seen.profiles_per_caliper / exact.profiles_per_caliper, 1, 0.05);
}

TEST_F(Stencil, SamePixelsEveryTime) {
  const Shape cube = measure_shape("cube", box_mesh({1, 1, 1}));
  EXPECT_EQ(stencil_statistics(cube, 10, 512, GlDevice::Cpu).cdf,
            stencil_statistics(cube, 10, 512, GlDevice::Cpu).cdf);
}

}  // namespace
}  // namespace terrazzo
