// The maps of Bake against the solid, against TextureSet, and along seams.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "nodes/bodies/carving/particle_index.h"
#include "nodes/common/texture/color.h"
#include "nodes/textures/bake/box_atlas.h"
#include "runtime/compute_node.h"
#include "runtime/random.h"
#include "tests/nodes/textures/bake/bake_cases.h"
#include "tests/support/all_nodes.h"
#include "tests/support/code_of.h"
#include "tests/support/readers.h"

namespace terrazzo {
namespace {
using namespace bake_cases;

TEST(Bake, APlaneHasTheMapsOfTextureSet) {
  const BakedSolid s = balls_on_a_lattice();
  const Detail detail = grain();
  const auto baked = bake_of(rectangle({0, -3}, {12, 9}, 1.4), s, {{"resolution", "240"}}, &detail);
  const auto set = test::run_node(
      "TextureSet",
      {{"particles", Value::of(s.particles)}, {"shapes", Value::of(s.shapes)}, {"detail", Value::of(detail)}},
      {{"resolution", "240"}, {"position", "1.4"}});
  for (const char* name : {"base_color", "normal", "height", "roughness", "occlusion", "id"}) {
    const Image &a = baked.output<Image>(name), &b = set.output<Image>(name);
    ASSERT_EQ(a.width, b.width);
    int different = 0;
    // The edge of the mesh has no neighbor that would tell an outline.
    for (int y = 1; y < b.height - 1; ++y)
      for (int x = 1; x < b.width - 1; ++x)
        different += (a.at(x, y) - b.at(x, y)).cwiseAbs().maxCoeff() > 1e-4f;
    EXPECT_LE(different, 5) << name;  // of 42,000: points of averages on an edge, by rounding
  }
}

// Calls visit(triangle, x, y, place) for the texels whose center is well inside a triangle, by its own
// arithmetic.
template <class Visit>
void each_inner_texel(const Shape& s, int size, const Visit& visit) {
  for (std::size_t t = 0; t < s.uv.size(); ++t) {
    const auto corner = [&](int k) { return Eigen::Vector2d(s.uv[t][k].cast<double>() * size); };
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return a.x() * b.y() - a.y() * b.x();
    };
    const Eigen::Vector2d low = corner(0).cwiseMin(corner(1)).cwiseMin(corner(2)),
                          high = corner(0).cwiseMax(corner(1)).cwiseMax(corner(2));
    const double area = cross(corner(1) - corner(0), corner(2) - corner(0));
    for (int y = round_down(low.y()); y <= high.y(); ++y)
      for (int x = round_down(low.x()); x <= high.x(); ++x) {
        const Eigen::Vector2d p(x + 0.5, y + 0.5);
        Vec3 place = Vec3::Zero();
        double least = 1;
        for (int k = 0; k < 3; ++k) {
          const double w = cross(corner((k + 1) % 3) - p, corner((k + 2) % 3) - p) / area;
          place += w * s.mesh.vertices[s.mesh.triangles[t][k]];
          least = std::min(least, w);
        }
        if (least > 0.01) visit(t, x, y, place);
      }
  }
}

TEST(Bake, TexelsAreTheSolidAtTheirPlaces) {
  const BakedSolid s = balls_on_a_lattice();
  const Detail detail = grain();
  Shape ball;
  ball.name = "ball";
  ball.mesh = geodesic_sphere(3);
  for (Vec3& v : ball.mesh.vertices) v = 5 * v + Vec3(1, 2, 3);
  const auto run = bake_of(ball, s, {{"resolution", "300"}, {"scale", "2"}, {"padding", "4"}}, &detail);
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_NE(run.warnings[0].find("no texture coordinates"), std::string::npos);
  EXPECT_EQ(run.metrics.at("overlapping"), 0);
  EXPECT_NEAR(run.metrics.at("mesh_size"), 20, 0.1);
  const Image &color = run.output<Image>("base_color"), &id = run.output<Image>("id");
  const Shape& mesh = run.output<Shapes>("mesh").shapes.at(0);
  EXPECT_EQ(mesh.mesh.triangles, ball.mesh.triangles);
  const carving::ParticleIndex index(s.particles, s.shapes);
  const residual::ResidualField field(detail, s.particles, color.pixel_size, residual::Keep::Power);
  int compared = 0, edges = 0;
  float worst = 0;
  each_inner_texel(mesh, 300, [&](std::size_t, int x, int y, const Vec3& place) {
    const Vec3 mm = 2 * place;
    const auto particle_at = [&](const Vec3& p) { return index.at(p.cast<float>()); };
    const int particle = particle_at(mm);
    for (const Vec3& d : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})  // no outline within two texels
      for (const double step : {-0.3, 0.3})
        if (particle_at(mm + step * d) != particle) {
          ++edges;
          return;
        }
    EXPECT_EQ(id.at(x, y), textures::id_color(particle)) << x << ", " << y;
    const Vec3f flat = linear_to_srgb(particle < 0 ? s.particles.binder_color : s.particles.color[particle]);
    const Vec3f expected = (flat + field.at(mm.cast<float>(), particle)).cwiseMax(0.0f).cwiseMin(1.0f);
    worst = std::max(worst, (linear_to_srgb(color.at(x, y)) - expected).cwiseAbs().maxCoeff());
    ++compared;
  });
  EXPECT_GT(compared, 5000);
  EXPECT_GT(edges, 1000);
  EXPECT_LE(worst, 1.0f / 255);
}

Vec3f bilinear(const Image& image, const Eigen::Vector2d& texel) {
  const Eigen::Vector2d p = texel - Eigen::Vector2d(0.5, 0.5);
  const int x = round_down(p.x()), y = round_down(p.y());
  const float s = static_cast<float>(p.x() - x), t = static_cast<float>(p.y() - y);
  return (1 - t) * ((1 - s) * image.at(x, y) + s * image.at(x + 1, y)) +
         t * ((1 - s) * image.at(x, y + 1) + s * image.at(x + 1, y + 1));
}

// Of particles, TextureSet shows those that emerge beside the worn binder; of a volume, both follow the
// outlines in the plane.
TEST(Bake, AWornPlaneOfAVolumeHasTheMapsOfTextureSet) {
  const Value volume = Value::of(waves(true, true));
  for (const char* relief : {"0.5", "-0.5"}) {
    const Settings common = {
        {"resolution", "96"}, {"relief", relief}, {"roughness", "[0.2]"}, {"binder_roughness", "0.5"}};
    Settings honed = common;
    honed["finish"] = "honed";
    honed["position"] = "3.3";
    const auto baked = test::run_node(
        "Bake", {{"mesh", Value::of(only(rectangle({0, 0}, {16, 16}, 3.3)))}, {"volume", volume}}, common);
    const auto set = test::run_node("TextureSet", {{"volume", volume}}, honed);
    for (const char* name : {"base_color", "normal", "height", "roughness", "occlusion"}) {
      const Image &a = baked.output<Image>(name), &b = set.output<Image>(name);
      ASSERT_EQ(a.width, b.width);
      ASSERT_EQ(a.height, b.height);
      int different = 0;
      // Bake rounds the roots of colors and densities to 16 bits.
      for (int y = 1; y < b.height - 1; ++y)
        for (int x = 1; x < b.width - 1; ++x)
          different += (a.at(x, y) - b.at(x, y)).cwiseAbs().maxCoeff() > 2e-3f;
      EXPECT_LE(different, 5) << name << ", relief " << relief;
    }
  }
}

// Beside the mesh's parts, the texture is no pit and no wall.
TEST(Bake, BlankTexelsDoNotTouchTheRelief) {
  const Shape part = rectangle({1, 1}, {5, 5}, 2, 0.25f, 0.25f, 0.75f, 0.75f);  // where density is 1
  for (const float relief : {0.5f, -0.5f}) {
    const auto run =
        test::run_node("Bake", {{"mesh", Value::of(only(part))}, {"volume", Value::of(waves(true, true))}},
                       {{"resolution", "128"}, {"padding", "2"}, {"relief", std::to_string(relief)}});
    const Image &height = run.output<Image>("height"), &normal = run.output<Image>("normal");
    const Image& occlusion = run.output<Image>("occlusion");
    for (int y = 32; y < 96; ++y)
      for (int x = 32; x < 96; ++x) {
        ASSERT_NEAR(height.at(x, y).x(), std::min(relief, 0.0f), 1e-4) << x << ", " << y;
        ASSERT_LT((normal.at(x, y) - Vec3f(0.5f, 0.5f, 1)).norm(), 1e-4f) << x << ", " << y;
        ASSERT_NEAR(occlusion.at(x, y).x(), 1, 1e-4) << x << ", " << y;
      }
    EXPECT_EQ(height.at(0, 0).x(), relief > 0 ? -relief : 0);  // as the binder
    EXPECT_EQ(occlusion.at(0, 0), Vec3f::Ones());
  }
}

// Padding has many more texels here than the triangles, of which one is a sliver.
TEST(Bake, TexelsHaveTheMeanSizeOfTheTriangles) {
  Shape s = rectangle({0, 0}, {1, 2}, 1, 0.4f, 0.4f, 0.6f, 0.6f);
  s.mesh.vertices.emplace_back(0, 5, 1);
  s.mesh.triangles.push_back({3, 2, 4});  // 1.5 mm²
  s.uv.push_back({s.uv[1][2], s.uv[1][1], s.uv[1][2] - Eigen::Vector2f(0, 0.005f)});
  const auto run = bake_of(s, balls_on_a_lattice(), {{"resolution", "200"}, {"padding", "60"}});
  EXPECT_NEAR(run.metrics.at("pixel_size"), std::sqrt(3.5 / (40 * 40 + 0.5 * 40)), 1e-4);
}

// At each edge of the mesh, the two triangles show the same colors, also where their charts are far apart.
TEST(Bake, NoSeamShows) {
  Shape ball;
  ball.mesh = geodesic_sphere(4);
  for (Vec3& v : ball.mesh.vertices) v *= 8;
  const auto run =
      test::run_node("Bake", {{"mesh", Value::of(only(ball))}, {"volume", Value::of(waves(true, true))}},
                     {{"resolution", "512"}, {"padding", "2"}});
  const Image& color = run.output<Image>("base_color");
  const Shape& s = run.output<Shapes>("mesh").shapes.at(0);
  std::map<std::pair<int, int>, std::pair<std::size_t, int>> other;
  int seams = 0;
  double worst = 0;
  for (std::size_t t = 0; t < s.uv.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = s.mesh.triangles[t][k], b = s.mesh.triangles[t][(k + 1) % 3];
      const auto [found, first] = other.try_emplace(std::minmax(a, b), t, k);
      if (first) continue;
      const CornerUv& back = s.uv[found->second.first];
      const int j = found->second.second;
      seams += (back[(j + 1) % 3] - s.uv[t][k]).norm() > 0.01f;
      for (double w = 0; w <= 1; w += 0.125) {
        const auto along = [&](const Eigen::Vector2f& from, const Eigen::Vector2f& to) {
          return Eigen::Vector2d(512 * ((1 - w) * from.cast<double>() + w * to.cast<double>()));
        };
        const Vec3f here = bilinear(color, along(s.uv[t][k], s.uv[t][(k + 1) % 3]));
        const Vec3f there = bilinear(color, along(back[(j + 1) % 3], back[j]));
        worst = std::max(worst, double{(here - there).cwiseAbs().maxCoeff()});
      }
    }
  EXPECT_GT(seams, 100);
  EXPECT_LT(worst, 0.01);  // the field changes by up to 0.015 per texel
}

TEST(Bake, PaddingContinuesTheSolid) {
  const BakedSolid s = balls_on_a_lattice();
  const Shape part = rectangle({3, 2}, {9, 8}, 1.4, 0.25f, 0.25f, 0.75f, 0.75f);  // texels of 0.1 mm
  const Shape whole = rectangle({0, -1}, {12, 11}, 1.4);
  const Image all = bake_of(whole, s, {{"resolution", "120"}}).output<Image>("id");
  for (const int padding : {0, 5}) {
    const auto run =
        bake_of(part, s, {{"resolution", "120"}, {"padding", std::to_string(padding)}, {"uv", "mesh"}});
    const Image &id = run.output<Image>("id"), &color = run.output<Image>("base_color");
    EXPECT_NEAR(run.metrics.at("covered"), 0.25, 1e-9);
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 120; ++x) {
        const int beyond = std::max({30 - x, x - 89, 30 - y, y - 89});
        if (beyond <= padding)
          ASSERT_EQ(id.at(x, y), all.at(x, y)) << x << ", " << y;
        else
          ASSERT_EQ(color.at(x, y), s.particles.binder_color) << x << ", " << y;
      }
  }
}

TEST(Bake, TrianglesWithACommonEdgeShareNoTexel) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed, 2, 0);
    // A fan around a random point, with corners on texel centers and lines.
    Mesh mesh;
    std::vector<CornerUv> uv;
    std::vector<Eigen::Vector2f> at = {Eigen::Vector2f(20 + round_nearest(random.uniform(0, 48)) / 2.0f,
                                                       20 + round_nearest(random.uniform(0, 48)) / 2.0f)};
    for (const auto& [x, y] :
         {std::pair(2, 2), {40, 3}, {62, 2}, {61, 35}, {62, 62}, {30, 60}, {2, 62}, {3, 30}})
      at.emplace_back(x, y);
    for (const auto& p : at) mesh.vertices.emplace_back(p.x(), -p.y(), 0);
    for (int k = 1; k <= 8; ++k) {
      mesh.triangles.push_back({0, k % 8 + 1, k});
      uv.push_back({at[0] / 64, at[k % 8 + 1] / 64, at[k] / 64});
    }
    const auto texels = bake::find_texels(mesh, uv, 64, 0);
    EXPECT_EQ(texels.overlapping, 0u);
    for (int y = 4; y < 60; ++y)
      for (int x = 4; x < 60; ++x) EXPECT_GE(texels.triangle[pixel_at(x, y, 64)], 0) << x << ", " << y;
  }
}

TEST(Bake, TrianglesWithoutAreaHaveNoTexels) {
  // On a line in the texture until its corners are rounded to 1 / 256 texel.
  Shape s = rectangle({0, 0}, {6, 6}, 0);
  s.mesh.triangles.insert(s.mesh.triangles.begin(), {0, 1, 2});
  s.uv.insert(s.uv.begin(),
              {Eigen::Vector2f(0.1f, 0.2f), Eigen::Vector2f(0.5f, 0.4f), Eigen::Vector2f(0.9f, 0.6f)});
  const auto texels = bake::find_texels(s.mesh, s.uv, 64, 0);
  EXPECT_EQ(texels.without_area, 1u);
  EXPECT_EQ(texels.covered, 64u * 64u);
  for (const std::int32_t t : texels.triangle) EXPECT_GT(t, 0);

  // Almost on a line in space.
  Shape line = rectangle({0, 0}, {6, 6}, 0);
  line.mesh.vertices = {{0, 0, 0}, {4, 0, 0}, {8, 1e-9, 0}, {4, 1e-9, 0}};
  const auto on_line = bake::find_texels(line.mesh, line.uv, 64, 0);
  const bake::TexelPlaces places(line.mesh, line.uv, 64, 1);
  textures::HeightField h{64, 64, 1, 1, std::vector<float>(64 * 64)};
  for (std::size_t i = 0; i < h.mm.size(); ++i) h.mm[i] = static_cast<float>(Random(1, 0, i).uniform(0, 1));
  for (const Vec3f& n : bake::normals_on_mesh(on_line, places, h).pixels) ASSERT_TRUE(n.allFinite());
}

TEST(Bake, SliversThatReachThroughTooManyRowsAreRefused) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles.assign(600, {0, 1, 2});
  const std::vector<CornerUv> uv(
      600, {Eigen::Vector2f(0, -60), Eigen::Vector2f(0, 60), Eigen::Vector2f(0.0001f, 0)});
  EXPECT_EQ(test::code_of([&] { bake::find_texels(mesh, uv, 16384, 0); }), "bad-uv");
}

// A slope of 0.2 along x in space, on a stretched, sheared and mirrored texture.
TEST(Bake, NormalsKnowTheTexturesAxes) {
  for (const bool mirrored : {false, true}) {
    Shape s = rectangle({0, 0}, {8, 4}, 0);
    for (CornerUv& t : s.uv)
      for (Eigen::Vector2f& uv : t) {
        uv = Eigen::Vector2f(0.2f + 0.5f * uv.x() + 0.2f * uv.y(), 0.1f + 0.8f * uv.y());
        if (mirrored) uv.x() = 1 - uv.x();
      }
    const auto texels = bake::find_texels(s.mesh, s.uv, 64, 2);
    const bake::TexelPlaces places(s.mesh, s.uv, 64, 1);
    textures::HeightField h{64, 64, 1, 1, std::vector<float>(64 * 64, 0.0f)};
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        if (const int t = texels.triangle[pixel_at(x, y, 64)]; t >= 0)
          h.mm[pixel_at(x, y, 64)] = static_cast<float>(0.2 * places.at(t, x, y, 0.5, 0.5).x());
    const Image normal = bake::normals_on_mesh(texels, places, h);
    const auto axes = places.axes(0);
    const Vec3 tangent = axes.right.normalized(), up = (mirrored ? -1 : 1) * axes.normal.cross(tangent);
    EXPECT_LT(up.dot(axes.down), 0);  // upwards in the picture
    const Vec3 expected = Vec3(-0.2, 0, 1).normalized();
    each_inner_texel(s, 64, [&](std::size_t, int x, int y, const Vec3&) {
      const Vec3 n = (2 * normal.at(x, y) - Vec3f::Ones()).cast<double>();
      ASSERT_LT((n.x() * tangent + n.y() * up + n.z() * axes.normal - expected).norm(), 1e-4)
          << x << ", " << y;
    });
  }
}

TEST(Bake, ReliefFollowsOutlines) {
  const BakedSolid s = balls_on_a_lattice();
  const Settings settings = {{"resolution", "240"}, {"relief", "0.3"}, {"roughness", "[0.1, 0.2, 0.3]"}};
  const auto run = bake_of(rectangle({0, -3}, {12, 9}, 1.4), s, settings);
  const Image &height = run.output<Image>("height"), &id = run.output<Image>("id");
  const auto binder = [&](int x, int y) { return id.at(x, y) == Vec3f::Zero(); };
  // Edges are rounded over √(2 · 0.15 · 0.3) mm, which is six texels of 0.05 mm.
  constexpr int kFar = 9;
  const auto alike = [&](int x, int y) {
    for (int dy = -kFar; dy <= kFar; ++dy)
      for (int dx = -kFar; dx <= kFar; ++dx)
        if (dx * dx + dy * dy <= kFar * kFar && binder(x + dx, y + dy) != binder(x, y)) return false;
    return true;
  };
  int inside = 0, outside = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 240; ++x) {
      const double h = double{height.at(x, y).x()};
      ASSERT_GE(h, -0.3001) << x << ", " << y;
      ASSERT_LE(h, 0.0001) << x << ", " << y;
      if (x < kFar || y < kFar || x >= 240 - kFar || y >= 240 - kFar || !alike(x, y)) continue;
      ASSERT_NEAR(h, binder(x, y) ? -0.3 : 0, 1e-4) << x << ", " << y;
      ++(binder(x, y) ? outside : inside);
    }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 1000);
}

TEST(Bake, ThreadsDoNotChangeTheMaps) {
  const Detail detail = grain();
  Shape ball;
  ball.mesh = geodesic_sphere(3);
  const Settings settings = {{"resolution", "128"}, {"relief", "0.1"}, {"scale", "3"}};
  const auto one = bake_of(ball, balls_on_a_lattice(), settings, &detail, 1),
             four = bake_of(ball, balls_on_a_lattice(), settings, &detail, 4);
  for (const auto& [name, value] : one.outputs)
    if (name != "mesh") {
      EXPECT_EQ(value.as<Image>().pixels, four.output<Image>(name).pixels) << name;
    }
}

}  // namespace
}  // namespace terrazzo
