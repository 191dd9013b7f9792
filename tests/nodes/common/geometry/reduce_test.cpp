// Simplification of scanned meshes.
#include "nodes/common/geometry/mesh/reduce.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/data/shapes.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "nodes/shapes/load_mesh/repair.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_mesh;

// An octahedron whose triangles are split into four repeatedly, on the unit sphere.
Mesh sphere(int cuts) {
  Mesh m;
  m.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const int top : {4, 5})
    for (const auto& [a, b] : {std::pair{0, 2}, {2, 1}, {1, 3}, {3, 0}})
      m.triangles.push_back(top == 4 ? Triangle{a, b, top} : Triangle{b, a, top});
  return test::refined_on_sphere(std::move(m), cuts);
}

TEST(ReduceTriangles, KeepsASphereASphere) {
  const Mesh fine = sphere(5);  // 8,192 triangles
  const double volume = mesh_volume(fine);
  ASSERT_NEAR(volume, 4.0 / 3 * std::numbers::pi, 0.01);
  for (const std::size_t triangles : {2000u, 500u, 100u}) {
    Mesh m = fine;
    reduce_triangles(m, triangles);
    EXPECT_LE(m.triangles.size(), triangles);
    EXPECT_GT(m.triangles.size(), triangles / 2);
    EXPECT_TRUE(mesh_faults(m).empty());
    // Vertices stay on the sphere. Inscribed polyhedra of n triangles lack about 13/n of its volume.
    EXPECT_NEAR(mesh_volume(m) / volume, 1, 15.0 / static_cast<double>(triangles)) << triangles;
    for (const auto& v : m.vertices) EXPECT_NEAR(v.norm(), 1, 1e-12) << triangles;
    Mesh again = fine;
    reduce_triangles(again, triangles);
    EXPECT_EQ(again.vertices, m.vertices);
    EXPECT_EQ(again.triangles, m.triangles);
  }
}

TEST(ReduceTriangles, LeavesASmallMeshAsItIs) {
  const Mesh before = sphere(1);
  Mesh m = before;
  reduce_triangles(m, before.triangles.size());
  EXPECT_EQ(m.vertices, before.vertices);
  EXPECT_EQ(m.triangles, before.triangles);
}

TEST(ReduceTriangles, SurfacesThatTouchAreAnError) {
  // Two tetrahedra with a common edge.
  Mesh m;
  m.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1}, {0, 4, 5, 1}})
    for (const Triangle& t : {Triangle{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}}) m.triangles.push_back(t);
  EXPECT_EQ(test::code_of([&] { reduce_triangles(m, 4); }), "bad-mesh");
}

TEST(ReduceTriangles, IsAParameterOfLoadMesh) {
  const auto folder = test::temporary_folder();
  const Mesh fine = sphere(4);
  std::ofstream out(folder / "s.off");
  out << "OFF\n" << fine.vertices.size() << ' ' << fine.triangles.size() << " 0\n";
  for (const auto& v : fine.vertices) out << v.transpose() << '\n';
  for (const auto& t : fine.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  out.close();
  const auto count = [&](const std::map<std::string, std::string>& more) {
    std::map<std::string, std::string> parameters = {{"path", (folder / "s.off").string()}};
    parameters.insert(more.begin(), more.end());
    return test::run_node("LoadMesh", {}, parameters)
        .output<Shapes>("shapes")
        .shapes.at(0)
        .mesh.triangles.size();
  };
  EXPECT_EQ(count({}), fine.triangles.size());
  EXPECT_LE(count({{"max_triangles", "300"}}), 300u);
}

}  // namespace
}  // namespace terrazzo
