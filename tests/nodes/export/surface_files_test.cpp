// Surfaces of a volume's regions: closed, periodic, of the right size.
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <sstream>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/export/surface_net.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

const Vec3i kSize(24, 20, 22);

// Two balls that touch, one of them across three sides, and a block between them.
std::int32_t ball_label(const Vec3i& n, std::size_t i) {
  const auto nx = static_cast<std::size_t>(n.x()), ny = static_cast<std::size_t>(n.y());
  const Vec3 p = Vec3(double(i % nx), double(i / nx % ny), double(i / nx / ny)) + Vec3::Constant(0.5);
  if (nearest_image(p - Vec3(1, 2, 3), n.cast<double>()).norm() < 6) return 0;
  if (nearest_image(p - Vec3(12, 10, 11), n.cast<double>()).norm() < 7) return 2;
  return p.x() > 16 && p.x() < 21 && p.y() > 5 && p.y() < 15 ? 5 : -1;
}

Volume balls(const Vec3i& n = kSize) {
  Volume v;
  add_id_grid(v, "id", n, Vec3::Constant(0.5), {}, [&](std::size_t i) { return ball_label(n, i); });
  v.resolution = n;
  return v;
}

SurfaceNet net_of(const Volume& v, int smoothing) {
  const VoxelBox box = voxel_box(v);
  const VoxelSource id(v, "id", box);
  return surface_net(id, box, find_regions(id, box, nullptr, RegionKind::Particles, {}), smoothing, 1u << 30,
                     {});
}

using Corners = std::array<std::int32_t, 3>;

// The surface of one region, with normals outward.
std::vector<Corners> surface_of(const SurfaceNet& net, std::int32_t region) {
  std::vector<Corners> out;
  for (std::size_t t = 0; t < net.corners.size(); ++t) {
    const SurfacePatch& p = net.patches[static_cast<std::size_t>(net.patch_of[t])];
    Corners c = net.corners[t];
    if (p.inside == region) out.push_back(c);
    if (p.other == region) out.push_back({c[0], c[2], c[1]});
  }
  return out;
}

double volume_of(const SurfaceNet& net, const std::vector<Corners>& surface) {
  double sum = 0;
  for (const Corners& c : surface) {
    const auto at = [&](std::size_t k) { return net.nodes[static_cast<std::size_t>(c[k])]; };
    sum += at(0).dot(at(1).cross(at(2))) / 6;
  }
  return sum;
}

// Whether every edge is used as often in one direction as in the other.
bool is_closed(const std::vector<Corners>& surface) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
  for (const Corners& c : surface)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = c[k], b = c[(k + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  return std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second == 0; });
}

TEST(SurfaceNet, RegionsAreClosedAndFillTheBox) {
  const Volume v = balls();
  std::array<double, 4> voxels{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(kSize.prod()); ++i) {
    const std::int32_t label = ball_label(kSize, i);
    voxels[label < 0 ? 0 : label == 0 ? 1 : label == 2 ? 2 : 3] += 0.125;
  }
  for (const int smoothing : {0, 10}) {
    const SurfaceNet net = net_of(v, smoothing);
    double sum = 0;
    for (std::int32_t r = 0; r < 4; ++r) {
      const auto surface = surface_of(net, r);
      EXPECT_TRUE(is_closed(surface)) << r;
      const double volume = volume_of(net, surface);
      EXPECT_NEAR(volume / voxels[static_cast<std::size_t>(r)], 1, smoothing ? 0.03 : 1e-9) << r;
      sum += volume;
    }
    EXPECT_NEAR(sum, kSize.prod() * 0.125, 1e-9);
    for (const Vec3& p : net.nodes) {
      EXPECT_TRUE((p.array() >= 0.25).all() &&
                  (p.array() <= 0.25 + 0.5 * kSize.cast<double>().array()).all());
    }
  }
}

TEST(SurfaceNet, OppositeSidesAreEqual) {
  const SurfaceNet net = net_of(balls(), 10);
  const Vec3 edge = 0.5 * kSize.cast<double>();
  for (int a = 0; a < 3; ++a) {
    std::map<std::int32_t, std::int32_t> image;
    for (const auto& [node, other] : net.periodic[static_cast<std::size_t>(a)]) {
      image[node] = other;
      const Vec3 d = net.nodes[static_cast<std::size_t>(node)] - net.nodes[static_cast<std::size_t>(other)];
      EXPECT_EQ(d[a], edge[a]);
      EXPECT_EQ(d[(a + 1) % 3], 0);
      EXPECT_EQ(d[(a + 2) % 3], 0);
    }
    // Triangles of one side, moved to the other and turned around, are those of the other, region by region.
    std::map<std::int32_t, std::vector<Corners>> low, high;
    for (std::size_t t = 0; t < net.corners.size(); ++t) {
      const SurfacePatch& p = net.patches[static_cast<std::size_t>(net.patch_of[t])];
      Corners c = net.corners[t];
      if (p.side == 2 * a + 1)
        for (auto& n : c) n = image.at(n);
      if (p.side != 2 * a && p.side != 2 * a + 1) continue;
      std::sort(c.begin(), c.end());
      (p.side == 2 * a ? low : high)[p.inside].push_back(c);
    }
    ASSERT_GE(low.size(), 2u);
    ASSERT_EQ(low.size(), high.size());
    for (auto& [region, all] : low) {
      std::sort(all.begin(), all.end());
      std::sort(high[region].begin(), high[region].end());
      EXPECT_EQ(all, high[region]) << a << " " << region;
    }
  }
}

TEST(SurfaceNet, SmoothingGivesABallItsSurface) {
  Volume v;
  const Vec3i n = Vec3i::Constant(40);
  add_id_grid(v, "id", n, Vec3::Ones(), {}, [&](std::size_t i) {
    const Vec3 p = Vec3(double(i % 40), double(i / 40 % 40), double(i / 1600)) + Vec3::Constant(0.5);
    return (p - Vec3::Constant(20)).norm() < 14 ? 0 : -1;
  });
  v.resolution = n;
  const auto area = [&](int smoothing) {
    const SurfaceNet net = net_of(v, smoothing);
    double sum = 0;
    for (const Corners& c : surface_of(net, 1)) {
      const auto at = [&](std::size_t k) { return net.nodes[static_cast<std::size_t>(c[k])]; };
      sum += 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
    }
    return sum / (4 * M_PI * 14 * 14);
  };
  EXPECT_NEAR(area(0), 1.5, 0.03);
  EXPECT_NEAR(area(10), 1, 0.05);
}

// The ball across three sides has eight pieces, one at each corner; each is closed by itself.
TEST(SurfaceNet, PiecesAreClosed) {
  const SurfaceNet net = net_of(balls(), 10);
  EXPECT_EQ(std::count(net.region_of_piece.begin(), net.region_of_piece.end(), 1), 8);
  EXPECT_EQ(std::count(net.region_of_piece.begin(), net.region_of_piece.end(), 2), 1);
  for (std::int32_t piece = 0; piece < static_cast<std::int32_t>(net.region_of_piece.size()); ++piece) {
    std::vector<Corners> surface;
    for (std::size_t t = 0; t < net.corners.size(); ++t) {
      const SurfacePatch& p = net.patches[static_cast<std::size_t>(net.patch_of[t])];
      Corners c = net.corners[t];
      if (p.inside_piece == piece) surface.push_back(c);
      if (p.side < 0 && p.other_piece == piece) surface.push_back({c[0], c[2], c[1]});
    }
    EXPECT_TRUE(is_closed(surface)) << piece;
    EXPECT_GT(volume_of(net, surface), 0) << piece;
  }
}

TEST(ExportMsh, HasNamesAndPeriodicNodes) {
  const fs::path out = test::temporary_folder();
  const auto run = test::run_node("Export", {{"volume", Value::of(balls())}}, {{"path", "a.msh"}}, out);
  std::istringstream in(test::content_of(out / "a.msh"));
  std::string text = in.str();
  for (const char* name : {"\"PARTICLE_0-BINDER\"", "\"PARTICLE_5-PARTICLE_2\"", "\"BINDER-X0\"",
                           "\"PARTICLE_0-Z1\"", "$Periodic"})
    EXPECT_NE(text.find(name), std::string::npos) << name;
  EXPECT_TRUE(fs::exists(out / "a.msh.csv"));
  const std::string script = test::content_of(out / "a.geo");
  EXPECT_NE(script.find("Merge \"a.msh\";"), std::string::npos);
  EXPECT_NE(script.find("Physical Volume(\"PARTICLE_5\")"), std::string::npos);
  EXPECT_GT(run.metrics.at("triangles"), 1000);
  Volume open = balls();
  open.resolution = Vec3i::Zero();
  test::run_node("Export", {{"volume", Value::of(open)}}, {{"path", "b.msh"}}, out);
  EXPECT_EQ(test::content_of(out / "b.msh").find("$Periodic"), std::string::npos);
}

TEST(ExportStl, OfAVolumeIsClosedAndLeavesVoidsOut) {
  const fs::path out = test::temporary_folder();
  Particles p;
  p.box = Vec3(12, 10, 11);
  p.resize(6);
  p.voids.assign(6, 0);
  p.voids[2] = 1;
  test::run_node("Export", {{"volume", Value::of(balls())}, {"particles", Value::of(p)}}, {{"path", "a.stl"}},
                 out);
  const std::string bytes = test::content_of(out / "a.stl");
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  ASSERT_EQ(bytes.size(), 84 + 50 * std::size_t{count});
  double volume = 0;
  std::map<std::array<float, 6>, int> edges;
  for (std::size_t t = 0; t < count; ++t) {
    float f[12];
    std::memcpy(f, bytes.data() + 84 + 50 * t, sizeof f);
    const Vec3 a(f[3], f[4], f[5]), b(f[6], f[7], f[8]), c(f[9], f[10], f[11]);
    volume += a.dot(b.cross(c)) / 6;
    for (int k = 0; k < 3; ++k) {
      std::array<float, 3> from, to;
      for (std::size_t x = 0; x < 3; ++x)
        from[x] = f[3 + 3 * static_cast<std::size_t>(k) + x],
        to[x] = f[3 + 3 * static_cast<std::size_t>((k + 1) % 3) + x];
      const bool up = from < to;
      const auto &low = up ? from : to, &high = up ? to : from;
      edges[{low[0], low[1], low[2], high[0], high[1], high[2]}] += up ? 1 : -1;
    }
  }
  for (const auto& [edge, balance] : edges) EXPECT_EQ(balance, 0);
  double solid = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(kSize.prod()); ++i) {
    const std::int32_t label = ball_label(kSize, i);
    solid += label >= 0 && label != 2 ? 0.125 : 0;
  }
  EXPECT_NEAR(volume / solid, 1, 0.03);
}

TEST(ExportSurfaces, RefuseWhatHasNone) {
  const auto code = [](const std::string& path, const std::multimap<std::string, Value>& inputs) {
    return test::code_of([&] {
      test::run_node("Export", inputs, {{"path", path}}, test::temporary_folder());
    });
  };
  Volume none;
  add_id_grid(none, "id", Vec3i(4, 4, 4), Vec3::Ones(), {}, [](std::size_t) { return -1; });
  none.resolution = Vec3i(4, 4, 4);
  EXPECT_EQ(code("a.stl", {{"volume", Value::of(none)}}), "no-particles");
  Volume density;
  add_number_grid(density, "density", Vec3i(4, 4, 4), Vec3::Ones(), {}, [](std::size_t) { return 1.0f; });
  EXPECT_EQ(code("a.msh", {{"volume", Value::of(density)}}), "no-id");
  EXPECT_EQ(code("a.stl", {{"volume", Value::of(balls())}, {"shapes", Value::of(test::two_shapes())}}),
            "format-does-not-fit");
  EXPECT_EQ(code("a.stl", {{"particles", Value::of(test::some_particles(3))}}), "missing-input");
  EXPECT_EQ(code("a\"b.msh", {{"volume", Value::of(balls())}}), "bad-names");
  EXPECT_EQ(code("a.msh", {{"particles", Value::of(test::some_particles(3))}}), "missing-input");
  EXPECT_EQ(test::code_of([] {
              const Volume v = balls();
              const VoxelBox box = voxel_box(v);
              const VoxelSource id(v, "id", box);
              surface_net(id, box, find_regions(id, box, nullptr, RegionKind::Particles, {}), 0, 1000, {});
            }),
            "too-large");
}

}  // namespace
}  // namespace terrazzo
