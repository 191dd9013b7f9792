#include "nodes/volumes/voxelize/voxelize.h"

#include <gtest/gtest.h>

#include <functional>

#include "nodes/data/volume.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace voxelize;

using test::code_of;

using openvdb::FloatGrid;
using openvdb::Int32Grid;
using openvdb::Vec3SGrid;
using test::cube_mesh;
using test::one_particle;
using test::random_turn;
using test::shapes_of;
using test::sphere_mesh;

struct Made {
  Volume volume;
  VoxelReport report;
  template <class Grid>
  auto values(const std::string& name) const {  // (i, j, k) → value, fast for neighboring voxels
    return [accessor = volume.find<Grid>(name)->getConstAccessor()](int i, int j, int k) {
      return accessor.getValue({i, j, k});
    };
  }
  template <class Grid>
  auto value(const std::string& name, int i, int j, int k) const {
    return volume.find<Grid>(name)->tree().getValue({i, j, k});
  }
};

Made make(const Particles& p, const Shapes& s, std::vector<std::int64_t> n,
          const Volume* residual = nullptr) {
  Made m;
  m.volume = voxelize::voxelize(p, s, residual, choose_lattice(p.box, n), m.report);
  return m;
}

template <class F>
void each_voxel(const Vec3i& n, F&& f) {
  for (int k = 0; k < n.z(); ++k)
    for (int j = 0; j < n.y(); ++j)
      for (int i = 0; i < n.x(); ++i) f(i, j, k);
}

TEST(Voxelize, SpheresOfAnySizeKeepTheirVolume) {
  const Shapes shapes = shapes_of(sphere_mesh(3));
  for (const double d : {0.04, 0.1, 0.5, 2.0, 3.9}) {
    Random r(4, 0, static_cast<std::uint64_t>(100 * d));
    const Made m = make(one_particle(Vec3::Constant(4), 4 * Vec3(r.uniform(), r.uniform(), r.uniform()), d),
                        shapes, {40});
    const double exact = std::numbers::pi / 6 * d * d * d / 64;
    EXPECT_NEAR(m.report.volume_fraction / exact, 1, d < 0.05 ? 0.05 : 0.005) << d;
    EXPECT_NEAR(m.report.exact_volume_fraction / exact, 1, 1e-9);
    double sum = 0;
    for (auto it = m.volume.find<FloatGrid>("density")->cbeginValueOn(); it; ++it) sum += *it;
    EXPECT_NEAR(sum / 64000, m.report.volume_fraction, 1e-6);
  }
}

TEST(Voxelize, IdsAreExact) {
  const Shapes shapes = shapes_of(cube_mesh());
  for (std::uint64_t trial = 0; trial < 6; ++trial) {
    Random r(8, 0, trial);
    Particles p;
    p.box = Vec3(4, 2, 3);
    p.resize(5);
    for (int i = 0; i < 5; ++i) {
      p.position[i] = p.box.cwiseProduct(Vec3(r.uniform(), r.uniform(), r.uniform()));
      p.orientation[i] = trial == 0 ? Quat::Identity() : random_turn(r);
      p.scale[i] = p.size[i] = r.uniform(0.3, 1.1) /* a diagonal below the box's edges */;
    }
    const Made m = make(p, shapes, {48});
    const double voxel = 4.0 / 48;
    const auto id = m.values<Int32Grid>("id");
    ASSERT_EQ(m.volume.resolution, Vec3i(48, 24, 36));
    each_voxel(m.volume.resolution, [&](int i, int j, int k) {
      const Vec3 x = voxel * (Vec3(i, j, k) + Vec3::Constant(0.5));
      int expected = -1;
      for (int q = 4; q >= 0; --q) {
        Vec3 d = x - p.position[q];
        for (int a = 0; a < 3; ++a) d[a] -= p.box[a] * std::round(d[a] / p.box[a]);
        if ((p.orientation[q].conjugate() * d).cwiseAbs().maxCoeff() < 0.5 * p.scale[q]) expected = q;
      }
      ASSERT_EQ(id(i, j, k), expected) << trial << " at " << x.transpose();
    });
  }
}

TEST(Voxelize, LatticePlanesOnFacesLeakNothing) {
  // The cube's faces, edges and vertices are at voxel centers and voxel faces, the worst case for rows of
  // samples.
  for (const double at : {2.0, 2.05}) {
    const Made m = make(one_particle(Vec3::Constant(4), Vec3::Constant(at), 1), shapes_of(cube_mesh()), {40});
    EXPECT_NEAR(m.report.volume_fraction, 1.0 / 64, 2e-3 / 64);
    std::size_t inside = m.volume.find<Int32Grid>("id")->activeVoxelCount();
    EXPECT_EQ(inside, 1000u);  // half-open intervals: no voxel is lost or counted twice
  }
}

TEST(Voxelize, AParticleAcrossTheCornerTiles) {
  const Shapes shapes = shapes_of(sphere_mesh(2));
  const Made corner = make(one_particle(Vec3::Constant(2), Vec3::Zero(), 1), shapes, {20});
  const Made middle = make(one_particle(Vec3::Constant(2), Vec3::Constant(1), 1), shapes, {20});
  int parts = 0;
  for (int c = 0; c < 8; ++c)
    parts += corner.value<Int32Grid>("id", c & 1 ? 19 : 0, c & 2 ? 19 : 0, c & 4 ? 19 : 0) == 0;
  EXPECT_EQ(parts, 8);
  EXPECT_EQ(corner.value<Int32Grid>("id", 10, 10, 10), -1);
  const auto id = corner.values<Int32Grid>("id"), id2 = middle.values<Int32Grid>("id");
  const auto density = corner.values<FloatGrid>("density"), density2 = middle.values<FloatGrid>("density");
  const auto surface = corner.values<FloatGrid>("surface"), surface2 = middle.values<FloatGrid>("surface");
  each_voxel(corner.volume.resolution, [&](int i, int j, int k) {
    const int x = (i + 10) % 20, y = (j + 10) % 20, z = (k + 10) % 20;
    ASSERT_EQ(id(i, j, k), id2(x, y, z));
    ASSERT_NEAR(density(i, j, k), density2(x, y, z), 1e-5);
    ASSERT_NEAR(surface(i, j, k), surface2(x, y, z), 1e-4);
  });
}

TEST(Voxelize, SurfaceIsTheDistance) {
  for (const double d : {0.35, 1.0, 3.0}) {
    const Made m =
        make(one_particle(Vec3::Constant(4), Vec3(1.93, 2.01, 2.07), d), shapes_of(sphere_mesh(3)), {40});
    const auto surface = m.volume.find<FloatGrid>("surface");
    EXPECT_EQ(surface->getGridClass(), openvdb::GRID_LEVEL_SET);
    EXPECT_FLOAT_EQ(surface->background(), 0.3f);
    double worst = 0;
    const auto id = m.values<Int32Grid>("id");
    const auto distance = m.values<FloatGrid>("surface");
    each_voxel(m.volume.resolution, [&](int i, int j, int k) {
      const Vec3 x = 0.1 * (Vec3(i, j, k) + Vec3::Constant(0.5));
      const double exact = std::clamp((x - Vec3(1.93, 2.01, 2.07)).norm() - d / 2, -0.3, 0.3);
      const float v = distance(i, j, k);
      worst = std::max(worst, std::abs(v - exact));
      ASSERT_EQ(v < 0, id(i, j, k) == 0);
    });
    EXPECT_LT(worst, 0.01 + 0.003 * d) << d;  // a tenth of a voxel, plus the mesh's facets
  }
}

TEST(Voxelize, ColorsMixByCoverage) {
  const Particles p = one_particle(Vec3::Constant(2), Vec3(1, 1, 1), 1.05);
  const Made m = make(p, shapes_of(cube_mesh()), {20});
  const auto density = m.values<FloatGrid>("density");
  const auto color = m.values<Vec3SGrid>("Cd");
  each_voxel(m.volume.resolution, [&](int i, int j, int k) {
    const float c = density(i, j, k);
    const auto v = color(i, j, k);
    const Vec3f expected = c * p.color[0] + (1 - c) * p.binder_color;
    ASSERT_LT((Vec3f(v[0], v[1], v[2]) - expected).norm(), 1e-5);
  });
  // Faces reach 0.25 voxels into the outer neighbors. A line's share of a voxel is exact only along x.
  EXPECT_NEAR(m.value<FloatGrid>("density", 4, 10, 10), 0.25, 1e-6);
  EXPECT_EQ(m.value<FloatGrid>("density", 10, 10, 10), 1);
  // Overlapping particles mix their colors and never exceed them.
  Particles two = p;
  two.resize(2);
  two.position[1] = p.position[0];
  two.scale[1] = 1.05;
  two.color[1] = Vec3f(0, 1, 0);
  const Made o = make(two, shapes_of(cube_mesh()), {20});
  const auto v = o.value<Vec3SGrid>("Cd", 10, 10, 10);
  EXPECT_NEAR(v[0], 0.4, 1e-5);
  EXPECT_EQ(o.value<Int32Grid>("id", 10, 10, 10), 0);
  EXPECT_EQ(o.report.without_voxel, 1u);
  EXPECT_NEAR(o.report.overlap_fraction + o.report.volume_fraction, 2 * std::pow(1.05, 3) / 8, 2e-3);
}

TEST(Voxelize, EqualForAnyNumberOfThreads) {
  Particles p;
  p.box = Vec3::Constant(4);
  p.resize(60);
  for (std::size_t i = 0; i < 60; ++i) {
    Random r(6, 0, i);
    p.position[i] = 4 * Vec3(r.uniform(), r.uniform(), r.uniform());
    p.orientation[i] = random_turn(r);
    p.scale[i] = p.size[i] = r.uniform(0.2, 1);
  }
  const auto bytes = [&](int threads) {
    const auto run = test::run_node(
        "Voxelize", {{"particles", Value::of(p)}, {"shapes", Value::of(shapes_of(sphere_mesh(2)))}},
        {{"resolution", "32"}}, {}, threads);
    BufferWriter w;
    run.outputs.at("volume").type().encode(run.outputs.at("volume").data(), w);
    return w.buffer;
  };
  EXPECT_EQ(bytes(1), bytes(3));
}

TEST(Voxelize, NoParticlesIsBinderAlone) {
  Particles p;
  p.box = Vec3::Ones();
  p.binder_color = Vec3f(0.2f, 0.3f, 0.4f);
  const Made m = make(p, {}, {16});
  EXPECT_EQ(m.report.volume_fraction, 0);
  EXPECT_EQ(m.volume.find<FloatGrid>("density")->activeVoxelCount(), 0u);
  EXPECT_FLOAT_EQ(m.value<Vec3SGrid>("Cd", 3, 3, 3)[2], 0.4f);
}

TEST(Voxelize, BadInputIsSaid) {
  const Shapes shapes = shapes_of(cube_mesh());
  const Particles good = one_particle(Vec3::Constant(2), Vec3::Ones(), 1);
  const auto broken = [&](auto&& change) {
    Particles p = good;
    change(p);
    return code_of([&] { make(p, shapes, {16}); });
  };
  EXPECT_EQ(broken([](Particles& p) { p.shape[0] = 1; }), "bad-particles");
  EXPECT_EQ(broken([](Particles& p) { p.position[0].x() = NAN; }), "bad-particles");
  EXPECT_EQ(broken([](Particles& p) { p.scale[0] = 0; }), "bad-particles");
  EXPECT_EQ(broken([](Particles& p) { p.orientation[0].w() = 2; }), "bad-particles");
  EXPECT_EQ(broken([](Particles& p) { p.color.clear(); }), "bad-particles");
  EXPECT_EQ(broken([](Particles& p) { p.box = Vec3::Zero(); }), "bad-box");
  Mesh open = cube_mesh();
  open.triangles.pop_back();
  EXPECT_EQ(code_of([&] { make(good, shapes_of(open), {16}); }), "open-mesh");
  EXPECT_EQ(code_of([] { choose_lattice(Vec3(4, 4, 3.3), {128}); }), "uneven-voxels");
  EXPECT_EQ(code_of([] { choose_lattice(Vec3(4, 4, 4), {8, 8, 9}); }), "uneven-voxels");
  EXPECT_EQ(code_of([] { choose_lattice(Vec3(4, 4, 4), {8, 8}); }), "bad-value");
  EXPECT_EQ(choose_lattice(Vec3(4, 3.3, 2), {40}).size, Vec3i(40, 33, 20));
  EXPECT_EQ(choose_lattice(Vec3(4, 3.3, 2), {40, 33, 20}).size, Vec3i(40, 33, 20));
}

}  // namespace
}  // namespace terrazzo
