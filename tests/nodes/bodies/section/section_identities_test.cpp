// Stereological identities between bodies and their sections (Underwood 1970; docs/validation.md).
#include <gtest/gtest.h>

#include "nodes/bodies/cutting/section.h"
#include "tests/nodes/bodies/section/packing.h"

namespace terrazzo {
namespace {
using namespace section;

using test::random_particles;

struct Truth {
  double N_V = 0, V_V = 0, H_sum = 0, V_sum = 0, S_sum = 0;  // sums over particles
};

Truth truth_of(const Particles& p, const Shapes& shapes) {
  Truth t;
  const double volume = p.box.prod();
  for (std::size_t i = 0; i < p.count(); ++i) {
    const Shape& s = shapes.shapes[p.shape[i]];
    const double k = p.scale[i];
    t.H_sum += s.mean_caliper * k;
    t.S_sum += s.surface_area * k * k;
    t.V_sum += s.volume * k * k * k;
  }
  t.N_V = p.count() / volume;
  t.V_V = t.V_sum / volume;
  return t;
}

struct Sums {
  double N_A = 0, A_A = 0, area = 0, perimeter = 0, weight = 0;
};

Sums sums_of(const Section& s) {
  Sums t;
  for (std::size_t i = 0; i < s.table.rows.size(); ++i) {
    const double w = s.table.number(i, "weight");
    t.weight += w;
    t.area += w * s.table.number(i, "area mm²");
    t.perimeter += w * s.table.number(i, "perimeter mm");
  }
  t.N_A = t.weight / s.profiles.observed_area;
  t.A_A = s.profiles.area_fraction;
  return t;
}

// Random planes through random convex particles.
class SectionIdentities : public ::testing::TestWithParam<int> {};

TEST_P(SectionIdentities, HoldForRandomPlanes) {
  Shapes shapes{{test::cube(), measure_shape("slab", test::box_mesh(1.6, 1.0, 0.4, Vec3(-.8, -.5, -.2)))}};
  const Particles particles = random_particles(GetParam(), 400, 12, 0.4, 1.2, 2);
  const Truth truth = truth_of(particles, shapes);
  SectionOptions choice;
  choice.axis = "random";
  choice.planes = 300;
  choice.seed = 7 + GetParam();
  const Section s = cut_section(particles, shapes, choose_planes(choice, particles.box, true, 1));
  const Sums sums = sums_of(s);
  const double volume = particles.box.prod();
  ASSERT_GT(s.profiles.profiles.size(), 3000u);
  // About 13,000 profiles in 300 planes. Over seeds, the ratios have spreads of 0.012, 0.007, 0.004 and
  // 0.011.
  EXPECT_NEAR(sums.N_A / (truth.H_sum / volume), 1, 0.05);
  EXPECT_NEAR(sums.area / sums.weight / (truth.V_sum / truth.H_sum), 1, 0.03);
  EXPECT_NEAR(sums.perimeter / sums.weight / (M_PI / 4 * truth.S_sum / truth.H_sum), 1, 0.02);
  // The area fraction counts overlaps once; adding them again gives the volume fraction.
  EXPECT_NEAR((sums.A_A + s.overlap) / truth.V_V, 1, 0.05);
  EXPECT_GT(s.overlap, 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SectionIdentities, ::testing::Values(1, 2, 3));

TEST(SectionIdentitiesAxis, AllDepthsIntegrateToVolumeAndCaliper) {
  // The planes are so dense that the sum over depths is an integral, exact for these particles in any
  // orientation.
  Shapes shapes{{test::cube()}};
  const Particles particles = random_particles(11, 60, 6, 0.6, 1.4);
  const Truth truth = truth_of(particles, shapes);
  for (const char* axis : {"x", "y", "z"}) {
    SectionOptions choice;
    choice.axis = axis;
    choice.planes = 600;
    const Section s = cut_section(particles, shapes, choose_planes(choice, particles.box, true, 2));
    double area = 0, extent = 0;
    for (const Profile& p : s.profiles.profiles) {
      area += p.area;
      EXPECT_EQ(p.weight, 1);
      EXPECT_FALSE(p.touches_border);
    }
    EXPECT_NEAR(area * 6 / 600 / truth.V_sum, 1, 2e-4);
    const int k = axis[0] - 'x';
    for (std::size_t i = 0; i < particles.count(); ++i) {
      double lo = 1e9, hi = -1e9;
      for (const Vec3& v : shapes.shapes[0].mesh.vertices) {
        const double h = (particles.orientation[i] * v)[k] * particles.scale[i];
        lo = std::min(lo, h);
        hi = std::max(hi, h);
      }
      extent += hi - lo;
    }
    EXPECT_NEAR(s.profiles.profiles.size() * 6.0 / 600 / extent, 1, 2e-3);
  }
}

TEST(SectionIdentitiesHoles, RingsMeetTheEulerIdentity) {
  // The mean over planes of Σχ (regions minus holes) is (1/4π) Σ L·θ over edges, where concave edges are
  // negative.
  Shapes shapes{{test::square_ring()}};
  const Particles particles = random_particles(3, 60, 12, 0.6, 1.2);
  SectionOptions choice;
  choice.axis = "random";
  choice.planes = 400;
  choice.seed = 5;
  const Section s = cut_section(particles, shapes, choose_planes(choice, particles.box, true, 1));
  // The shape must produce regions with holes and multiple regions.
  double chi = 0, holes = 0;
  for (std::size_t i = 0; i < s.table.rows.size(); ++i) {
    const double w = s.table.number(i, "weight"), h = s.table.number(i, "holes");
    chi += w * (1 - h);
    holes += h;
  }
  EXPECT_GT(holes, 20);
  double scales = 0;
  for (double k : particles.scale) scales += k;
  const double expected = mesh_edge_curvature(shapes.shapes[0].mesh) * scales / particles.box.prod();
  EXPECT_NEAR(chi / s.profiles.observed_area / expected, 1, 0.1);
}

}  // namespace
}  // namespace terrazzo
