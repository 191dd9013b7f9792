// Particles that reach out of the box: cut at its sides or repeated at the opposite ones.
#include "nodes/export/tiled_packing.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstring>
#include <numbers>
#include <set>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/export/cut_mesh.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

// A ring whose sections have holes, or two parts.
Mesh ring(double radius, double thickness, int around = 40, int across = 16) {
  Mesh m;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around, b = 2 * std::numbers::pi * j / across;
      const double r = radius + thickness * std::cos(b);
      m.vertices.emplace_back(r * std::cos(a), r * std::sin(a), thickness * std::sin(b));
    }
  const auto at = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return m;
}

Shapes rings_and_cubes() {
  Shapes s;
  s.shapes = {measure_shape("ring", ring(2, 0.7)), measure_shape("cube", test::cube_mesh(2)),
              measure_shape("grain", ring(1.2, 0.5, 9, 5))};
  s.shapes[0].smooth = true;
  return s;
}

Particles scattered(std::size_t count, const Vec3& box, std::uint64_t seed) {
  Particles p = test::some_particles(count, seed);
  p.box = box;
  for (std::size_t i = 0; i < count; ++i) {
    Random r(seed, 6, i);
    p.shape[i] = static_cast<std::int32_t>(i % 3);
    p.position[i] = Vec3(r.uniform(), r.uniform(), r.uniform()).cwiseProduct(box);
  }
  return p;
}

Mesh placed(const Particles& p, const Shapes& s, std::size_t i) {
  Mesh m = s.shapes[p.shape[i]].mesh;
  transform(m, p.orientation[i].toRotationMatrix() * p.scale[i], p.position[i]);
  return m;
}

TEST(CutMesh, PartsAreClosedAndKeepTheVolume) {
  const Shapes shapes = rings_and_cubes();
  for (const Vec3& box :
       {Vec3(9, 8, 7), Vec3(2, 1.5, 3)}) {  // in the second, particles are larger than the box
    const Particles p = scattered(150, box, 3);
    for (std::size_t i = 0; i < p.count(); ++i) {
      const Mesh whole = placed(p, shapes, i);
      double volume = 0;
      for (const Mesh& part : parts_in_box(whole, box)) {
        ASSERT_EQ(mesh_faults(part), std::vector<std::string>{}) << i;
        for (const Vec3& v : part.vertices)
          ASSERT_TRUE((v.array() >= 0).all() && (v.array() <= box.array()).all()) << v.transpose();
        ASSERT_GT(mesh_volume(part), 0);
        volume += mesh_volume(part);
      }
      ASSERT_NEAR(volume, mesh_volume(whole), 1e-9 * mesh_volume(whole)) << i;
    }
  }
}

TEST(CutMesh, OutlinesOnOppositeSidesAreEqualToTheBit) {
  const Shapes shapes = rings_and_cubes();
  const Vec3 box(9, 8, 7);
  const Particles p = scattered(120, box, 4);
  for (int axis = 0; axis < 3; ++axis) {
    std::set<std::array<double, 2>> low, high;
    for (std::size_t i = 0; i < p.count(); ++i)
      for (const Mesh& part : parts_in_box(placed(p, shapes, i), box))
        for (const Vec3& v : part.vertices) {
          const std::array<double, 2> at = {v[(axis + 1) % 3], v[(axis + 2) % 3]};
          // Edges of the box, where caps meet caps, have corners of their own.
          if (at[0] == 0 || at[0] == box[(axis + 1) % 3] || at[1] == 0 || at[1] == box[(axis + 2) % 3])
            continue;
          if (v[axis] == 0) low.insert(at);
          if (v[axis] == box[axis]) high.insert(at);
        }
    EXPECT_GT(low.size(), 200u);
    EXPECT_EQ(low, high) << axis;
  }
}

TEST(CutMesh, PlanesThroughVerticesAndFaces) {
  const Mesh cube = test::cube_mesh(2);
  EXPECT_NEAR(mesh_volume(cut_mesh(cube, 0, 1, true)), 8, 1e-12);  // a face on the plane
  EXPECT_TRUE(cut_mesh(cube, 0, 1, false).triangles.empty());
  Mesh octahedron;
  octahedron.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                          {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const Mesh half = cut_mesh(octahedron, 2, 0, false);  // through four vertices
  EXPECT_EQ(mesh_faults(half), std::vector<std::string>{});
  EXPECT_NEAR(mesh_volume(half), 2.0 / 3, 1e-12);
  Mesh open = cube;
  open.triangles.pop_back();
  EXPECT_EQ(test::code_of([&] { cut_mesh(open, 2, 0.3, true); }), "open-mesh");
}

TEST(TiledPacking, PartsFillTheBoxAsTheParticlesDo) {
  const Shapes shapes = rings_and_cubes();
  Particles p = scattered(60, Vec3(9, 8, 7), 5);
  p.voids.assign(p.count(), 0);
  p.voids[7] = 1;
  const TiledPacking tiled = tiled_packing(p, shapes, Crossing::Cut, true, 1 << 30);
  double whole = 0, written = 0;
  for (std::size_t i = 0; i < p.count(); ++i)
    if (!p.is_void(i)) whole += mesh_volume(placed(p, shapes, i));
  std::vector<bool> seen(p.count());
  for (std::size_t i = 0; i < tiled.particles.count(); ++i) {
    written += mesh_volume(placed(tiled.particles, tiled.shapes, i));
    seen.at(tiled.index[i]) = true;
    EXPECT_EQ(tiled.particles.color[i], p.color[tiled.index[i]]);
  }
  EXPECT_NEAR(written, whole, 1e-9 * whole);
  EXPECT_NEAR(tiled.fraction, whole / p.box.prod(), 1e-9);
  EXPECT_GT(tiled.parts, 60u);
  for (std::size_t i = 0; i < p.count(); ++i) EXPECT_EQ(seen[i], i != 7);
}

// How often a closed mesh winds around a point.
double winding(const Mesh& m, const Vec3& p) {
  double sum = 0;  // solid angles (van Oosterom and Strackee 1983)
  for (const Triangle& t : m.triangles) {
    const Vec3 a = m.vertices[t[0]] - p, b = m.vertices[t[1]] - p, c = m.vertices[t[2]] - p;
    const double x = a.norm(), y = b.norm(), z = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y);
  }
  return sum / (4 * std::numbers::pi);
}

TEST(TiledPacking, RepeatedAndCutPackingsFillTheSamePointsOfTheBox) {
  const Shapes shapes = rings_and_cubes();
  const Particles p = scattered(12, Vec3(5, 6, 4), 8);
  const TiledPacking repeated = tiled_packing(p, shapes, Crossing::Repeated, true, 1 << 30),
                     cut = tiled_packing(p, shapes, Crossing::Cut, true, 1 << 30);
  EXPECT_GT(repeated.particles.count(), p.count());
  EXPECT_EQ(repeated.shapes.shapes.size(), shapes.shapes.size());
  const auto covers = [](const TiledPacking& t, const Vec3& at) {
    double sum = 0;
    for (std::size_t i = 0; i < t.particles.count(); ++i)
      sum += winding(placed(t.particles, t.shapes, i), at);
    return std::lround(sum);
  };
  int inside = 0;
  for (std::size_t k = 0; k < 200; ++k) {
    Random r(1, 2, k);
    const Vec3 at = Vec3(r.uniform(), r.uniform(), r.uniform()).cwiseProduct(p.box);
    long periodic = 0;
    for (std::size_t i = 0; i < p.count(); ++i)
      for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
          for (int z = -2; z <= 2; ++z)
            periodic += std::lround(winding(placed(p, shapes, i), at + Vec3(x, y, z).cwiseProduct(p.box)));
    EXPECT_EQ(covers(repeated, at), periodic);
    EXPECT_EQ(covers(cut, at), periodic);
    inside += periodic > 0;
  }
  EXPECT_GT(inside, 20);
}

TEST(TiledPacking, CapsOfSmoothShapesHaveTheirOwnVertices) {
  const Vec3 box(4, 4, 4);
  Mesh part = test::cube_mesh(2);
  transform(part, Mat3::Identity(), Vec3(3, 2, 2));  // its right face is on a side
  const Mesh flat = with_flat_caps(part, box);
  EXPECT_EQ(flat.vertices.size(), 12u);
  EXPECT_EQ(flat.triangles.size(), part.triangles.size());
  EXPECT_DOUBLE_EQ(mesh_volume(flat), 8);
}

// --- files

double volume_of_stl(const fs::path& file) {
  const std::string bytes = test::content_of(file);
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  EXPECT_EQ(bytes.size(), 84 + 50 * std::size_t{count});
  double six = 0;
  for (std::uint32_t t = 0; t < count; ++t) {
    float v[12];
    std::memcpy(v, bytes.data() + 84 + 50 * std::size_t{t}, sizeof v);
    const auto at = [&](int k) { return Vec3(v[3 * k], v[3 * k + 1], v[3 * k + 2]); };
    six += at(1).dot(at(2).cross(at(3)));
  }
  return six / 6;
}

TEST(TiledPacking, FilesHoldTheFraction) {
  const fs::path out = test::temporary_folder();
  const Particles p = scattered(40, Vec3(9, 8, 7), 6);
  const Shapes shapes = rings_and_cubes();
  const std::multimap<std::string, Value> inputs = {{"particles", Value::of(p)},
                                                    {"shapes", Value::of(shapes)}};
  const auto run = [&](const std::string& path, const char* crossing) {
    return test::run_node("Export", inputs, {{"path", path}, {"crossing", crossing}}, out).metrics;
  };
  auto metrics = run("cut.stl", "cut");
  EXPECT_NEAR(volume_of_stl(out / "cut.stl") / p.box.prod(), metrics.at("fraction"), 1e-5);
  run("once.stl", "once");
  EXPECT_NEAR(volume_of_stl(out / "once.stl") / p.box.prod(), metrics.at("fraction"), 1e-5);

  run("cut.obj", "cut");
  const std::string obj = test::content_of(out / "cut.obj");
  std::size_t objects = 0;
  for (std::size_t at = obj.find("\no "); at != std::string::npos; at = obj.find("\no ", at + 1)) ++objects;
  EXPECT_EQ(double(objects), metrics.at("instances"));
  EXPECT_NE(obj.find("o cube_"), std::string::npos);

  run("cut.ply", "cut");
  EXPECT_NE(test::content_of(out / "cut.ply").find("property uchar red"), std::string::npos);

  for (const char* crossing : {"once", "repeated", "cut"}) {
    metrics = run("a.glb", crossing);
    tinygltf::Model m;
    std::string error, warning;
    tinygltf::TinyGLTF reader;
    ASSERT_TRUE(reader.LoadBinaryFromFile(&m, &error, &warning, (out / "a.glb").string())) << error;
    double instances = 0;
    for (const auto& node : m.nodes) {
      const auto& e = node.extensions.at("EXT_mesh_gpu_instancing");
      instances += double(m.accessors.at(e.Get("attributes").Get("_ID").GetNumberAsInt()).count);
    }
    EXPECT_EQ(instances, metrics.count("instances") ? metrics.at("instances") : double(p.count()))
        << crossing;
  }
  run("a.usda", "repeated");
  EXPECT_NE(test::content_of(out / "a.usda").find("int[] primvars:particle = ["), std::string::npos);
}

TEST(TiledPacking, RefusesWhatCannotBeWritten) {
  const fs::path out = test::temporary_folder();
  Particles p = scattered(3, Vec3(4, 4, 4), 1);
  Shapes open = rings_and_cubes();
  for (Shape& s : open.shapes) s.mesh.triangles.pop_back();
  p.scale.assign(3, 2);
  const auto code = [&](const Particles& particles, const Shapes& shapes, const char* path,
                        const char* crossing) {
    return test::code_of([&] {
      test::run_node("Export", {{"particles", Value::of(particles)}, {"shapes", Value::of(shapes)}},
                     {{"path", path}, {"crossing", crossing}}, out);
    });
  };
  EXPECT_EQ(code(p, open, "a.glb", "cut"), "open-mesh");
  EXPECT_EQ(code(p, open, "a.obj", "repeated"), "open-mesh");
  Particles flat = p;
  flat.box.z() = 0;
  EXPECT_EQ(code(flat, rings_and_cubes(), "a.stl", "cut"), "bad-box");
  Particles huge = p;
  huge.scale[1] = 1e9;
  EXPECT_EQ(code(huge, rings_and_cubes(), "a.stl", "repeated"), "box-too-small");
  for (const double far : {1e20, -1e300}) {
    Particles away = p;
    away.position[2].y() = far;
    for (const char* crossing : {"repeated", "cut"})
      EXPECT_EQ(code(away, rings_and_cubes(), "a.stl", crossing), "bad-number") << far << crossing;
  }
  Shapes torn = rings_and_cubes();
  for (Shape& s : torn.shapes) s.mesh.vertices[0].x() = std::nan("");
  EXPECT_EQ(code(p, torn, "a.stl", "cut"), "bad-number");
  EXPECT_EQ(test::code_of([&] { tiled_packing(p, rings_and_cubes(), Crossing::Cut, true, 1000); }),
            "too-large");
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Export", {{"particles", Value::of(p)}}, {{"path", "a.obj"}}, out);
            }),
            "no-shapes");
  EXPECT_TRUE(fs::is_empty(out));
}

}  // namespace
}  // namespace terrazzo
