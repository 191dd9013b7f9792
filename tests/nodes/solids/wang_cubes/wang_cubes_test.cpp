#include "nodes/solids/wang_cubes/wang_cubes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/data/table.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace wang_cubes;
using patch_fill::wrapped;

constexpr int kEdge = 24;

// Smooth blobs that tile: white noise after a few means with neighbors.
Torus<Vec3f> blobs() {
  Torus<Vec3f> out(Vec3i::Constant(kEdge), Vec3f::Zero());
  for (std::size_t i = 0; i < out.at.size(); ++i)
    out.at[i] = Vec3f::Constant(static_cast<float>(Random(5, 0, i).normal()));
  for (int round = 0; round < 2; ++round)
    for (int a = 0; a < 3; ++a) {
      const Torus<Vec3f> from = out;
      for (std::size_t i = 0; i < out.at.size(); ++i) {
        Vec3f sum = Vec3f::Zero();
        for (int k = -1; k <= 1; ++k) {
          Vec3i p = from.place(i);
          p[a] = wrapped(p[a] + k, kEdge);
          sum += from.at[from.index(p.x(), p.y(), p.z())];
        }
        out.at[i] = sum / 3;
      }
    }
  for (Vec3f& v : out.at) v = Vec3f::Constant(0.5f + 0.4f * std::tanh(10 * v.x()));
  return out;
}

TEST(WangCubes, NeighborsShareTheColorOfTheirFace) {
  const Lattice l = random_lattice(Vec3i(4, 3, 2), 3, 7);
  const Torus<int> at(l.cubes, 0);
  std::set<int> colors;
  for (std::size_t i = 0; i < l.faces.size(); ++i)
    for (int a = 0; a < 3; ++a) {
      Vec3i p = at.place(i);
      p[a] = wrapped(p[a] + 1, l.cubes[a]);
      const auto k = static_cast<std::size_t>(a);
      EXPECT_EQ(l.faces[i].high[k], l.faces[at.index(p.x(), p.y(), p.z())].low[k]);
      colors.insert(l.faces[i].low[k]);
    }
  EXPECT_EQ(colors.size(), 3u);
}

TEST(WangCubes, EqualCubesAreNoNeighbors) {
  const Lattice l = random_lattice(Vec3i(6, 6, 6), 2, 1);
  const Torus<int> at(l.cubes, 0);
  int alike = 0;
  for (std::size_t i = 0; i < l.faces.size(); ++i)
    for (int a = 0; a < 3; ++a) {
      Vec3i p = at.place(i);
      p[a] = wrapped(p[a] + 1, l.cubes[a]);
      alike += l.faces[at.index(p.x(), p.y(), p.z())] == l.faces[i];
    }
  EXPECT_EQ(alike, 0);  // about 20 of 648 pairs by chance
}

TEST(WangCubes, OneColorRepeatsTheSolid) {
  const Torus<Vec3f> solid = blobs();
  const Lattice l = random_lattice(Vec3i(2, 1, 1), 1, 1);
  const CubeSet set = make_cubes(solid, l, {.colors = 1, .rim = 2, .fill = {}}, Work());
  ASSERT_EQ(set.cube.size(), 1u);
  EXPECT_EQ(set.cube[0].at, solid.at);
  EXPECT_NEAR(repetition(assemble(set, l), l.cubes), 1, 1e-9);
}

// Cubes differ, and yet nothing shows where one ends: no plane has steps larger than those within the solid.
TEST(WangCubes, ContinueEachOtherWithoutRepeating) {
  const Torus<Vec3f> solid = blobs();
  const Lattice l = random_lattice(Vec3i(4, 3, 1), 2, 3);
  CubeOptions s;
  s.fill.iterations = {12};
  const CubeSet set = make_cubes(solid, l, s, Work());
  EXPECT_GE(set.cube.size(), 6u);
  const Torus<Vec3f> whole = assemble(set, l);
  ASSERT_EQ(whole.size, Vec3i(4 * kEdge, 3 * kEdge, kEdge));
  // Faces of equal color and all edges repeat, which is much of so small a cube.
  EXPECT_LT(repetition(whole, l.cubes), 0.75);

  const auto steps = [](const Torus<Vec3f>& t, int axis) {
    std::vector<double> out(static_cast<std::size_t>(t.size[axis]));
    for (std::size_t i = 0; i < t.at.size(); ++i) {
      Vec3i p = t.place(i);
      const auto plane = static_cast<std::size_t>(p[axis]);
      p[axis] = wrapped(p[axis] + 1, t.size[axis]);
      out[plane] += std::abs(t.at[t.index(p.x(), p.y(), p.z())].x() - t.at[i].x());
    }
    for (double& v : out) v *= static_cast<double>(t.size[axis]) / static_cast<double>(t.at.size());
    return out;
  };
  for (int a = 0; a < 3; ++a) {
    const auto of_solid = steps(solid, a);
    const double most = *std::max_element(of_solid.begin(), of_solid.end());
    for (const double v : steps(whole, a)) EXPECT_LT(v, 1.3 * most) << "axis " << a;
  }
  // The colors are the solid's.
  double sum = 0, square = 0, from = 0, from_square = 0;
  for (const Vec3f& c : whole.at) {
    sum += c.x();
    square += c.x() * c.x();
  }
  for (const Vec3f& c : solid.at) {
    from += c.x();
    from_square += c.x() * c.x();
  }
  const double n = static_cast<double>(whole.at.size()), m = static_cast<double>(solid.at.size());
  EXPECT_NEAR(sum / n, from / m, 0.03);
  EXPECT_NEAR(square / n, from_square / m, 0.03);
}

TEST(WangCubes, AllCubesAreTheSolidAlongTheirEdges) {
  const Torus<Vec3f> solid = blobs();
  const Lattice l = random_lattice(Vec3i(2, 2, 1), 2, 3);
  CubeOptions s;
  s.fill.iterations = {2};
  s.rim = 3;
  const CubeSet set = make_cubes(solid, l, s, Work());
  int inside = 0;
  for (std::size_t i = 0; i < solid.at.size(); ++i) {
    const Vec3i p = solid.place(i);
    int near = 0;
    for (int a = 0; a < 3; ++a) near += p[a] < 3 || p[a] >= kEdge - 3;
    for (const auto& cube : set.cube) {
      if (near >= 2) {
        ASSERT_EQ(cube.at[i], solid.at[i]);
      }
      inside += near == 0 && cube.at[i] != solid.at[i];
    }
  }
  EXPECT_GT(inside, 1000);
}

TEST(WangCubes, ReportsWhatItMade) {
  const Torus<Vec3f> solid = blobs();
  Volume v;
  v.resolution = solid.size;
  add_vector_grid(v, "Cd", solid.size, 0.5, Work(), [&](std::size_t i) { return solid.at[i]; });
  const std::map<std::string, std::string> row = {{"cubes", "[2, 1, 1]"}, {"iterations", "2"}};
  const auto run = test::run_node("WangCubes", {{"solid", Value::of(v)}}, row);
  EXPECT_EQ(run.output<Table>("table").rows.size(), 2u);
  EXPECT_EQ(run.output<Volume>("volume").resolution, Vec3i(48, 24, 24));
  EXPECT_LE(run.metrics.at("cubes_made"), 2);
  const auto code = [&](const std::map<std::string, std::string>& p) {
    return test::code_of([&] { test::run_node("WangCubes", {{"solid", Value::of(v)}}, p); });
  };
  EXPECT_EQ(code({{"rim", "10"}}), "too-small");
  EXPECT_EQ(code({{"cubes", "[2, 2]"}}), "bad-value");
}

}  // namespace
}  // namespace terrazzo
