// Power diagrams: what must hold for every tessellation, and literature values for random seeds.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/packing/cells/cell_mesh.h"
#include "nodes/packing/cells/prescribed_volumes.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace tessellation;

Seeds random_seeds(const Vec3& box, std::size_t n, std::uint64_t seed, double weights = 0) {
  Seeds s;
  s.box = box;
  Random r(seed);
  for (std::size_t i = 0; i < n; ++i) {
    s.position.push_back(Vec3(r.uniform(), r.uniform(), r.uniform()).cwiseProduct(box));
    s.weight.push_back(weights * r.uniform());
  }
  return s;
}

TEST(PowerDiagram, FillsTheBoxAndNeighborsShareFaces) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Seeds s = random_seeds(Vec3(3, 5, 4), 200, seed, 0.02);
    const auto cells = power_diagram(s);
    double sum = 0;
    std::map<std::pair<int, int>, double> area;  // from … to: signed, so that both sides cancel
    for (std::size_t i = 0; i < cells.size(); ++i) {
      sum += cells[i].volume;
      if (cells[i].corners.empty()) continue;
      std::set<std::pair<int, int>> edges;
      std::size_t sides = 0;
      for (const Face& f : cells[i].faces) {
        ASSERT_GE(f.neighbor, 0);
        const int me = static_cast<int>(i);
        area[std::minmax(me, f.neighbor)] += me < f.neighbor ? f.area : -f.area;
        sides += f.corners.size();
        for (int c : f.corners)
          EXPECT_NEAR(f.normal.dot(cells[i].corners[c] - cells[i].corners[f.corners[0]]), 0, 1e-9);
      }
      // Euler: corners − edges + faces = 2, and each edge belongs to two faces
      EXPECT_EQ(cells[i].corners.size() + cells[i].faces.size(), sides / 2 + 2);
    }
    EXPECT_NEAR(sum / s.box.prod(), 1, 1e-9);
    EXPECT_GT(area.size(), 1000u);
    for (const auto& [pair, difference] : area) EXPECT_NEAR(difference, 0, 1e-8);
  }
}

TEST(PowerDiagram, ACellHoldsThePointsWithTheSmallestPower) {
  const Seeds s = random_seeds(Vec3(2, 2, 3), 60, 7, 0.05);
  const auto cells = power_diagram(s);
  Random r(3);
  for (int k = 0; k < 300; ++k) {
    const Vec3 x = Vec3(r.uniform(), r.uniform(), r.uniform()).cwiseProduct(s.box);
    std::size_t nearest = 0;
    double least = 1e300;
    Vec3 to = Vec3::Zero();
    for (std::size_t i = 0; i < s.count(); ++i) {
      Vec3 d = x - s.position[i];
      for (int a = 0; a < 3; ++a) d[a] -= s.box[a] * std::round(d[a] / s.box[a]);
      if (const double power = d.squaredNorm() - s.weight[i]; power < least)
        least = power, nearest = i, to = d;
    }
    for (const Plane& p : planes_of(cells[nearest])) EXPECT_LT(p.normal.dot(to), p.offset + 1e-9);
  }
}

// Mean values of Poisson–Voronoi cells (Meijering 1953; Okabe et al. 2000, table 5.5.1): 15.535 faces,
// surface 5.821 and total edge length 17.496 for unit mean volume.
TEST(PowerDiagram, PoissonVoronoi) {
  const std::size_t n = 4000;
  const auto cells = power_diagram(random_seeds(Vec3::Constant(std::cbrt(double(n))), n, 11));
  double faces = 0, surface = 0, edges = 0;
  for (const ConvexCell& c : cells) {
    faces += double(c.faces.size()) / n;
    for (const Face& f : c.faces) {
      surface += f.area / n;
      for (std::size_t k = 0; k < f.corners.size(); ++k)
        edges +=
            0.5 * (c.corners[f.corners[k]] - c.corners[f.corners[(k + 1) % f.corners.size()]]).norm() / n;
    }
  }
  // Standard deviations of single cells: 3.34, 1.0, 2.6
  EXPECT_NEAR(faces, 15.535, 4 * 3.34 / std::sqrt(double(n)));
  EXPECT_NEAR(surface, 5.821, 4 * 1.0 / std::sqrt(double(n)));
  EXPECT_NEAR(edges, 17.496, 4 * 2.6 / std::sqrt(double(n)));
}

TEST(PowerDiagram, FewSeeds) {
  for (std::size_t n : {1u, 2u, 3u}) {
    const Seeds s = random_seeds(Vec3(1, 2, 3), n, 5);
    double sum = 0;
    for (const ConvexCell& c : power_diagram(s)) {
      sum += c.volume;
      EXPECT_TRUE(mesh_faults(cell_mesh(c)).empty());
    }
    EXPECT_NEAR(sum, 6, 1e-9);
  }
}

TEST(PrescribedVolumes, AreMetForAnySizes) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Seeds s = random_seeds(Vec3(4, 3, 5), 150, seed);
    Random r(seed, 9);
    std::vector<double> volume;
    for (std::size_t i = 0; i < s.count(); ++i) volume.push_back(std::exp(1.2 * r.normal()));
    const double total = std::accumulate(volume.begin(), volume.end(), 0.0);
    Effort effort;
    const VolumeFit fit = fit_volumes(s, volume, 1e-6, effort);
    EXPECT_LE(fit.worst, 1e-6);
    const auto cells = power_diagram(s);
    for (std::size_t i = 0; i < cells.size(); ++i)
      EXPECT_NEAR(cells[i].volume, volume[i] / total * 60, 2e-6 * volume[i] / total * 60);
  }
}

TEST(PrescribedVolumes, CentroidsMakeCellsRounder) {
  const auto sphericity = [](int rounds) {
    Seeds s = random_seeds(Vec3::Constant(4), 120, 3);
    Effort effort;
    fit_round_cells(s, std::vector<double>(120, 1.0), 1e-3, rounds, effort);
    double mean = 0;
    for (const ConvexCell& c : power_diagram(s)) {
      double area = 0;
      for (const Face& f : c.faces) area += f.area;
      mean += std::cbrt(36 * 3.14159265358979 * c.volume * c.volume) / area / 120;
    }
    return mean;
  };
  const double before = sphericity(0), after = sphericity(20);
  EXPECT_GT(after, before + 0.05);
  EXPECT_LT(after, 0.92);  // space-filling cells cannot be spheres: Kelvin's cell has 0.910
}

TEST(PrescribedVolumes, EqualSeedsAreAnError) {
  Seeds s = random_seeds(Vec3::Ones(), 4, 1);
  s.position[1] = s.position[0];
  Effort effort;
  EXPECT_EQ(test::code_of([&] { fit_volumes(s, {1, 1, 1, 1}, 1e-3, effort); }), "not-converged");
}

TEST(CellMesh, RoundedCellsStayInside) {
  const auto cells = power_diagram(random_seeds(Vec3::Constant(2), 30, 2));
  for (const ConvexCell& c : cells) {
    double before = c.volume;
    for (const double roundness : {0.05, 0.2, 1.0}) {
      Mesh mesh = cell_mesh(c);
      round_edges(mesh, planes_of(c), c.centroid, roundness);
      for (const Vec3& v : mesh.vertices)
        for (const Plane& p : planes_of(c)) EXPECT_LE(p.normal.dot(v), p.offset + 1e-12);
      EXPECT_LT(mesh_volume(mesh), before);
      before = mesh_volume(mesh);
    }
    EXPECT_GT(before, 0);
  }
}

}  // namespace
}  // namespace terrazzo
