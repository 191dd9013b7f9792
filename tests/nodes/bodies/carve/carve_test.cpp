// Carved bodies compared with closed forms, with colors that are known at every point, and with what
// RenderSolid's rays meet.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/bodies/carve/atlas.h"
#include "nodes/bodies/carve/subdivide.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/solid.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/image.h"
#include "nodes/data/volume.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace carve;

constexpr double pi = std::numbers::pi;

// 20 voxels of 0.5 mm along each edge: one period is 10 mm.
template <class Color>
Volume colored_volume(bool periodic, Color&& color) {
  initialize_openvdb();
  Volume v;
  const Vec3i n(20, 20, 20);
  if (periodic) v.resolution = n;
  v.grids.push_back(dense_grid<openvdb::Vec3SGrid>("Cd", n, 0.5, {}, [&](std::size_t i) {
    const Vec3f c = color(Vec3(double(i % 20) + 0.5, double(i / 20 % 20) + 0.5, double(i / 400) + 0.5) * 0.5);
    return openvdb::Vec3s(c.x(), c.y(), c.z());
  }));
  return v;
}

Value body_value(const Mesh& mesh, bool smooth = true) {
  Shapes s;
  s.shapes.push_back(measure_shape("body", mesh));
  s.shapes[0].smooth = smooth;
  return Value::of(std::move(s));
}

const Shape& carved_shape(const test::NodeRun& run) { return run.output<Shapes>("shapes").shapes.at(0); }

double longest_edge(const Mesh& m) {
  double out = 0;
  for (const Triangle& t : m.triangles)
    for (int k = 0; k < 3; ++k) out = std::max(out, (m.vertices[t[k]] - m.vertices[t[(k + 1) % 3]]).norm());
  return out;
}

TEST(Carve, ASphereOfOneColorHasItsAreaVolumeDistanceAndColor) {
  const Vec3f red(0.7f, 0.2f, 0.1f);
  const auto run =
      test::run_node("Carve",
                     {{"volume", Value::of(colored_volume(true, [&](const Vec3&) { return red; }))},
                      {"object", body_value(test::sphere_mesh(4))}},
                     {{"edge", "0.3"}});
  const Shape& s = carved_shape(run);
  EXPECT_TRUE(mesh_faults(s.mesh).empty());
  EXPECT_LE(longest_edge(s.mesh), 0.3);
  // The longest edge of the period becomes the longest side of the object: a diameter of 10 mm.
  EXPECT_NEAR(s.volume, 1000 * pi / 6, 3);
  EXPECT_NEAR(s.surface_area, 100 * pi, 0.6);
  EXPECT_NEAR(s.mean_caliper, 10, 0.02);
  EXPECT_NEAR(s.max_section_area, 25 * pi, 0.4);
  EXPECT_LT(mesh_centroid(s.mesh).norm(), 1e-9);
  ASSERT_EQ(s.color.size(), s.mesh.vertices.size());
  for (const Vec3f& c : s.color) ASSERT_LT((c - red).norm(), 1e-4f);
  EXPECT_TRUE(s.uv.empty());
  EXPECT_LT((run.output<Image>("texture").pixels.at(0) - red).norm(), 1e-4f);

  const auto& volume = run.output<Volume>("volume");
  const auto surface = volume.find<openvdb::FloatGrid>("surface");
  const auto colors = volume.find<openvdb::Vec3SGrid>("Cd");
  ASSERT_TRUE(surface && colors);
  EXPECT_EQ(surface->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_EQ(surface->activeVoxelCount(), colors->activeVoxelCount());
  for (auto at = surface->cbeginValueOn(); at; ++at) {
    const auto w = surface->transform().indexToWorld(at.getCoord());
    // OpenVDB's distances are exact near the surface and approximate at the border of the band.
    ASSERT_NEAR(*at, w.length() - 5, std::abs(*at) < 0.3f ? 0.05 : 0.15);
    const auto c = colors->tree().getValue(at.getCoord());
    ASSERT_LT((Vec3f(c.x(), c.y(), c.z()) - red).norm(), 1e-4f);
  }
  EXPECT_LT(surface->tree().getValue(openvdb::Coord(16, 16, 16)), 0);
}

TEST(Carve, ColorsAreTheSolidsAtEachVertexAndPixel) {
  // Linear in space, which every interpolation keeps exactly.
  const auto color_at = [](const Vec3& p) {
    return Vec3f(float(0.2 + 0.05 * p.x()), float(0.9 - 0.06 * p.y()), float(0.3 + 0.03 * p.z()));
  };
  const auto run = test::run_node(
      "Carve",
      {{"volume", Value::of(colored_volume(false, color_at))}, {"object", body_value(geodesic_sphere(3))}},
      {{"repeat", "0.5"}, {"shift", "[0.25, 0.25, 0.25]"}, {"edge", "0.4"}, {"texture", "512"}});
  const Shape& s = carved_shape(run);
  const Vec3 middle = Vec3::Constant(5);  // 2.5 mm of the body, 2.5 mm of the shift
  for (std::size_t v = 0; v < s.color.size(); ++v)
    ASSERT_LT((s.color[v] - color_at(s.mesh.vertices[v] + middle)).norm(), 2e-3f);
  const Image& texture = run.output<Image>("texture");
  ASSERT_EQ(texture.width, 512);
  ASSERT_EQ(s.uv.size(), s.mesh.triangles.size());
  for (std::size_t t = 0; t < s.uv.size(); ++t)
    for (std::uint64_t k = 0; k < 4; ++k) {  // anywhere in the triangle, linearly between pixels
      Random r(3, t, k);
      double u = r.uniform(), v = r.uniform();
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const auto& c = s.uv[t];
      const Eigen::Vector2f at = (c[0] + float(u) * (c[1] - c[0]) + float(v) * (c[2] - c[0])) * 512 -
                                 Eigen::Vector2f::Constant(0.5f);
      const int x = int(std::floor(at.x() + 1e-3f)), y = int(std::floor(at.y() + 1e-3f));
      const float fx = std::max(0.0f, at.x() - float(x)), fy = std::max(0.0f, at.y() - float(y));
      ASSERT_TRUE(x >= 0 && y >= 0 && x < 512 && y < 512);
      const int x1 = std::min(511, x + 1), y1 = std::min(511, y + 1);
      const Vec3f seen = (1 - fy) * ((1 - fx) * texture.at(x, y) + fx * texture.at(x1, y)) +
                         fy * ((1 - fx) * texture.at(x, y1) + fx * texture.at(x1, y1));
      const auto& q = s.mesh.triangles[t];
      const Vec3 p = s.mesh.vertices[q[0]] + u * (s.mesh.vertices[q[1]] - s.mesh.vertices[q[0]]) +
                     v * (s.mesh.vertices[q[2]] - s.mesh.vertices[q[0]]);
      ASSERT_LT((seen - color_at(p + middle)).norm(), 0.01f) << t << " at " << u << ", " << v;
    }
}

Particles balls(const std::vector<Vec3>& at, double diameter, bool voids = false) {
  Particles p;
  p.box = Vec3::Constant(10);
  p.resize(at.size());
  p.position = at;
  for (std::size_t i = 0; i < at.size(); ++i) {
    p.scale[i] = p.size[i] = diameter;
    p.color[i] = Vec3f(0.8f, 0.1f * float(i + 1), 0.05f);
    if (voids) p.voids.push_back(1);
  }
  p.binder_color = Vec3f(0.3f, 0.35f, 0.4f);
  return p;
}

Value ball_shapes() {
  Shapes s;
  s.shapes = {measure_shape("ball", test::sphere_mesh(4))};
  s.shapes[0].smooth = true;
  return Value::of(std::move(s));
}

// What RenderSolid's rays meet is what the mesh has.
TEST(Carve, ColorsAreThoseOfRenderSolidsRays) {
  Shapes shapes;
  shapes.shapes = {measure_shape("ball", test::sphere_mesh(4))};
  const Particles p = balls({Vec3(2, 2, 2), Vec3(7, 3, 5), Vec3(4, 8, 7), Vec3(0, 5, 9)}, 3.5);
  const auto run = test::run_node("Carve",
                                  {{"particles", Value::of(p)},
                                   {"shapes", Value::of(shapes)},
                                   {"object", body_value(test::sphere_mesh(3))}},
                                  {{"turn", "[20, 30, 40]"}, {"repeat", "1.5"}, {"edge", "0.3"}});
  const Shape& s = carved_shape(run);
  const auto paint =
      carving::particle_paint(p, shapes, 1.5, carving::Placement::of(Vec3(20, 30, 40), Vec3::Zero()));
  Shape object = measure_shape("body", test::sphere_mesh(3));
  object.smooth = true;
  const auto solid = carving::object_solid(*paint, object);
  const Vec3f middle = solid->bounds().center();
  int same = 0, kinds = 0;
  for (std::size_t v = 0; v < s.color.size(); ++v) {
    const Vec3f out = s.mesh.vertices[v].cast<float>().normalized();
    carving::SurfacePoint hit;
    ASSERT_TRUE(solid->nearest(middle + 3 * out, -out, hit, true));
    ASSERT_LT((hit.position - middle - s.mesh.vertices[v].cast<float>() / 15).norm(), 1e-4f);
    same += hit.albedo == s.color[v];
    kinds += s.color[v] != p.binder_color;
  }
  // Rounding may decide on a particle's outline.
  EXPECT_GT(same, 0.995 * double(s.color.size()));
  EXPECT_GT(kinds, 0.05 * double(s.color.size()));
  EXPECT_LT(kinds, 0.95 * double(s.color.size()));
}

TEST(Carve, ABlockIsClosedFlatAndExact) {
  const auto volume = Value::of(colored_volume(true, [](const Vec3&) { return Vec3f::Constant(0.5f); }));
  const auto block = test::run_node("Carve", {{"volume", volume}}, {{"cut", "0.4"}, {"edge", "0.7"}});
  EXPECT_TRUE(mesh_faults(carved_shape(block).mesh).empty());
  EXPECT_NEAR(carved_shape(block).volume, 1000 * (1 - 0.064), 1e-6);
  EXPECT_NEAR(carved_shape(block).surface_area, 600, 1e-6);
  const auto cube = test::run_node("Carve", {{"volume", volume}}, {{"mode", "cube"}, {"edge", "2"}});
  EXPECT_NEAR(carved_shape(cube).volume, 1000, 1e-6);
}

TEST(Carve, VoidsAreHolesInsideAndOpen) {
  // One ball in the middle, closed in, and one around the corners, which opens the block.
  const Particles p = balls({Vec3(5, 5, 5), Vec3(0, 0, 0)}, 4, true);
  const auto run = test::run_node("Carve", {{"particles", Value::of(p)}, {"shapes", ball_shapes()}},
                                  {{"mode", "cube"}, {"edge", "0.2"}});
  const Shape& s = carved_shape(run);
  EXPECT_TRUE(mesh_faults(s.mesh).empty());
  EXPECT_NEAR(s.volume, 1000 - 2 * 32 * pi / 3, 2);
  for (const Vec3f& c : s.color) ASSERT_LT((c - p.binder_color).norm(), 1e-5f);
  int inner = 0;
  for (const Vec3& v : s.mesh.vertices) inner += std::abs(v.norm() - 2) < 0.02;
  EXPECT_GT(inner, 500);
}

TEST(Carve, AFractureKeepsParticlesAndLeavesSockets) {
  // The flat face is at 5 mm. One ball stays and sticks out by 1 mm more than half; one leaves a socket.
  const Particles p = balls({Vec3(3, 3, 4.5), Vec3(7, 7, 5.5)}, 3);
  const auto run =
      test::run_node("Carve", {{"particles", Value::of(p)}, {"shapes", ball_shapes()}},
                     {{"mode", "fracture"}, {"level", "0.5"}, {"roughness", "0"}, {"edge", "0.12"}});
  const Shape& s = carved_shape(run);
  EXPECT_TRUE(mesh_faults(s.mesh).empty());
  // What sticks out of the face is a cap of height 1, and so is the socket.
  EXPECT_NEAR(s.volume, 500, 0.5);
  const double cap = 2 * pi * 1.5 * 1, disc = pi * (1.5 * 1.5 - 0.25);
  // Where a ball meets the face, the edge is cut off within a voxel.
  EXPECT_NEAR(s.surface_area, 400 + 2 * (cap - disc), 2.2);
  // Undo the shift to the centroid with the corner.
  Vec3 low = Vec3::Constant(1e9);
  for (const Vec3& v : s.mesh.vertices) low = low.cwiseMin(v);
  int on_ball = 0, in_socket = 0, on_sides = 0;
  for (std::size_t i = 0; i < s.color.size(); ++i) {
    const Vec3 at = s.mesh.vertices[i] - low;
    if (at.z() > 5.1) {
      EXPECT_NEAR((at - Vec3(3, 3, 4.5)).norm(), 1.5, 0.01);
      EXPECT_LT((s.color[i] - p.color[0]).norm(), 1e-5f);
      ++on_ball;
    } else if (std::abs((at - Vec3(7, 7, 5.5)).norm() - 1.5) < 0.01) {
      EXPECT_LT((s.color[i] - p.binder_color).norm(), 1e-5f);
      ++in_socket;
    }
    on_sides += at.minCoeff() < 1e-5;
  }
  EXPECT_GT(on_ball, 300);
  EXPECT_GT(in_socket, 300);
  EXPECT_GT(on_sides, 5000);
}

TEST(Carve, ItsLevelSetKeepsCavities) {
  Mesh shell = geodesic_sphere(3), inside = geodesic_sphere(3);
  const auto first = static_cast<std::int32_t>(shell.vertices.size());
  for (const Vec3& v : inside.vertices) shell.vertices.push_back(0.5 * v);
  for (const Triangle& t : inside.triangles)
    shell.triangles.push_back({first + t[0], first + t[2], first + t[1]});
  const auto run = test::run_node(
      "Carve",
      {{"volume", Value::of(colored_volume(true, [](const Vec3&) { return Vec3f::Constant(0.5f); }))},
       {"object", body_value(shell)}},
      {{"edge", "0.4"}});
  const auto surface = run.output<Volume>("volume").find<openvdb::FloatGrid>("surface");
  const auto at = [&](double x) {
    const auto i = surface->transform().worldToIndexNodeCentered(openvdb::Vec3d(x, 0, 0));
    return surface->tree().getValue(i);
  };
  EXPECT_GT(at(0), 0);
  EXPECT_LT(at(3.75), 0);
  EXPECT_GT(at(5.6), 0);
}

TEST(Carve, ErrorsNameWhatIsMissing) {
  const auto volume = Value::of(colored_volume(true, [](const Vec3&) { return Vec3f::Constant(0.5f); }));
  const auto code = [&](const std::multimap<std::string, Value>& inputs,
                        const std::map<std::string, std::string>& parameters) {
    return test::code_of([&] { test::run_node("Carve", inputs, parameters); });
  };
  EXPECT_EQ(code({}, {}), "no-volume");
  EXPECT_EQ(code({{"volume", volume}}, {{"mode", "object"}}), "no-object");
  EXPECT_EQ(code({{"volume", volume}}, {{"mode", "fracture"}}), "no-particles");
  EXPECT_EQ(code({{"volume", volume}}, {{"edge", "0.0001"}}), "too-large");
  EXPECT_EQ(code({{"volume", volume}}, {{"edge", "0.5"}, {"texture", "64"}}), "bad-value");
  Particles off = balls({Vec3(5, 5, 5)}, 3);
  off.shape[0] = 7;
  EXPECT_EQ(code({{"particles", Value::of(off)}, {"shapes", ball_shapes()}}, {{"mode", "fracture"}}),
            "no-such-shape");
}

TEST(Subdivide, SplitsClosedMeshesIntoClosedMeshes) {
  Mesh m = geodesic_sphere(0);
  m.vertices[3] *= 9;  // long and short edges
  const double volume = mesh_volume(m), area = mesh_surface_area(m);
  subdivide(m, 0.2);
  EXPECT_TRUE(mesh_faults(m).empty());
  EXPECT_LE(longest_edge(m), 0.2);
  EXPECT_NEAR(mesh_volume(m), volume, 1e-9);
  EXPECT_NEAR(mesh_surface_area(m), area, 1e-9);
}

}  // namespace
}  // namespace terrazzo
