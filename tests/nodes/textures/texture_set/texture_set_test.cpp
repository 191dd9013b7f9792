// The maps of TextureSet against the solid itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "nodes/bodies/carving/particle_index.h"
#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/detail.h"
#include "nodes/data/volume.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/textures/texture_set/texture_maps.h"
#include "runtime/compute_node.h"
#include "runtime/random.h"
#include "tests/support/all_nodes.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

struct Stones {
  Particles particles;
  Shapes shapes;
};

// Spheres and cubes on a lattice with random shifts, which do not overlap.
Stones lattice_of_stones() {
  Stones s;
  s.shapes.shapes = {measure_shape("ball", geodesic_sphere(3)), measure_shape("cube", test::cube_mesh(1.2))};
  s.shapes.shapes[0].probability = s.shapes.shapes[1].probability = 0.5;
  s.particles.box = Vec3(12, 9, 6);
  s.particles.resize(4 * 3 * 2);
  for (int i = 0; i < 24; ++i) {
    Random random(7, 1, static_cast<std::uint64_t>(i));
    s.particles.position[i] = 3.0 * Vec3(i % 4, i / 4 % 3, i / 12) + 1.3 * Vec3::Ones();
    for (int k = 0; k < 3; ++k) s.particles.position[i][k] += random.uniform(-0.25, 0.25);
    s.particles.shape[i] = i % 2;
    s.particles.cls[i] = i % 3;
    s.particles.scale[i] = random.uniform(0.9, 1.2);
    s.particles.size[i] = 2 * s.particles.scale[i];
    s.particles.orientation[i] =
        Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    s.particles.color[i] =
        Vec3f(random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), random.uniform(0.1, 0.9));
  }
  s.particles.binder_color = Vec3f(0.3f, 0.25f, 0.2f);
  return s;
}

// One ball of radius 1 in a box of 4 mm.
Stones one_ball(double z, bool is_void = false) {
  Stones s;
  s.shapes.shapes.resize(1);  // without measures, which would take seconds
  s.shapes.shapes[0].mesh = geodesic_sphere(6);
  s.particles.box = Vec3::Constant(4);
  s.particles.resize(1);
  s.particles.position[0] = Vec3(2, 2, z);
  s.particles.size[0] = 2;
  s.particles.color[0] = Vec3f(0.8f, 0.1f, 0.1f);
  s.particles.binder_color = Vec3f::Constant(0.2f);
  if (is_void) s.particles.voids = {1};
  return s;
}

Detail speckle() {
  Detail d;
  d.pixel_size = 0.1;
  d.size = 16;
  for (std::uint64_t k = 0; k < 2; ++k) {
    Detail::Phase phase;
    for (std::uint64_t i = 0; i < 16 * 16 * 16; ++i)
      phase.tile.push_back(Vec3f::Constant(static_cast<float>(0.05 * Random(1, k, i).normal())));
    phase.tilt = Eigen::Vector2f(0.1f, 0.05f);  // the photograph's light, which is not part of the material
    d.phases.push_back(std::move(phase));
  }
  return d;
}

using Settings = std::map<std::string, std::string>;

test::NodeRun maps_of(const Stones& s, const Settings& parameters, const Detail* detail = nullptr,
                      int threads = 0) {
  std::multimap<std::string, Value> inputs = {{"particles", Value::of(s.particles)},
                                              {"shapes", Value::of(s.shapes)}};
  if (detail) inputs.emplace("detail", Value::of(*detail));
  return test::run_node("TextureSet", inputs, parameters, {}, threads);
}

// Whether the texel and all its neighbors show the same particle.
bool inside(const Image& id, int x, int y) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (id.at((x + dx + id.width) % id.width, (y + dy + id.height) % id.height) != id.at(x, y))
        return false;
  return true;
}

TEST(TextureSet, TexelsAreTheSolidAtTheirPlaces) {
  const Stones s = lattice_of_stones();
  Detail detail = speckle();
  const auto run = maps_of(s, {{"resolution", "240"}, {"position", "1.4"}}, &detail);
  const Image &color = run.output<Image>("base_color"), &id = run.output<Image>("id");
  ASSERT_EQ(color.width, 240);
  ASSERT_EQ(color.height, 180);
  for (Detail::Phase& phase : detail.phases) phase.tilt.setZero();
  const carving::ParticleIndex index(s.particles, s.shapes);
  const residual::ResidualField field(detail, s.particles, 0.05, residual::Keep::Power);
  float worst = 0;
  int compared = 0;
  for (int y = 0; y < color.height; ++y)
    for (int x = 0; x < color.width; ++x) {
      const Vec3f mm(static_cast<float>((x + 0.5) * 0.05), static_cast<float>((180 - y - 0.5) * 0.05), 1.4f);
      const int particle = index.at(mm);
      if (!inside(id, x, y)) continue;
      ASSERT_EQ(id.at(x, y), texture_set::id_color(particle)) << x << ", " << y;
      const Vec3f flat =
          linear_to_srgb(particle < 0 ? s.particles.binder_color : s.particles.color[particle]);
      const Vec3f expected = (flat + field.at(mm, particle)).cwiseMax(0.0f).cwiseMin(1.0f);
      worst = std::max(worst, (linear_to_srgb(color.at(x, y)) - expected).cwiseAbs().maxCoeff());
      ++compared;
    }
  EXPECT_GT(compared, 30000);
  EXPECT_LE(worst, 1.0f / 255);
}

TEST(TextureSet, EdgesAreThoseOfSection) {
  const Stones s = lattice_of_stones();
  const Image color = maps_of(s, {{"axis", "x"}, {"resolution", "180"}}).output<Image>("base_color");
  const Image section =
      test::run_node("Section", {{"particles", Value::of(s.particles)}, {"shapes", Value::of(s.shapes)}},
                     {{"axis", "x"}, {"pixel_size", "0.05"}})
          .output<Image>("image");
  ASSERT_EQ(color.width, section.width);
  ASSERT_EQ(color.height, section.height);
  double worst = 0, sum = 0;
  for (std::size_t i = 0; i < color.pixels.size(); ++i) {
    const double d = (color.pixels[i] - section.pixels[i]).cwiseAbs().maxCoeff();
    worst = std::max(worst, d);
    sum += d;
  }
  EXPECT_LT(worst, 0.15);  // 4 × 4 points against exact coverage, of colors that differ by up to 0.8
  EXPECT_LT(sum / color.pixels.size(), 0.002);
}

// The solid moved by whole texels gives the same maps, moved: no texel knows where the tile ends.
TEST(TextureSet, MapsHaveThePeriodOfTheSolid) {
  const Stones s = lattice_of_stones();
  for (const char* finish : {"polished", "weathered"}) {
    const Settings settings = {{"resolution", "120"}, {"finish", finish}};
    const auto a = maps_of(s, settings);
    Stones moved = s;
    const int dx = 37, dy = 53;  // texels of 0.1 mm, to the right and upwards
    for (Vec3& p : moved.particles.position) {
      p.x() = std::fmod(p.x() + 0.1 * dx, 12);
      p.y() = std::fmod(p.y() + 0.1 * dy, 9);
    }
    const auto b = maps_of(moved, settings);
    for (const char* name : {"base_color", "normal", "height", "roughness", "occlusion", "id"}) {
      const Image &one = a.output<Image>(name), &other = b.output<Image>(name);
      int different = 0;
      for (int y = 0; y < one.height; ++y)
        for (int x = 0; x < one.width; ++x) {
          const Vec3f d = one.at(x, y) - other.at((x + dx) % one.width, (y - dy + one.height) % one.height);
          different += d.cwiseAbs().maxCoeff() > 2e-3f;
        }
      EXPECT_LE(different, 10) << finish << " " << name;  // of 10,800: points on an edge, by rounding
    }
  }
}

TEST(TextureSet, PolishedIsFlatWithTheDefaultsOfItsRoughness) {
  const auto run = maps_of(lattice_of_stones(), {{"resolution", "60"}, {"position", "1.4"}});
  EXPECT_EQ(run.metrics.at("height_min"), 0);
  EXPECT_EQ(run.metrics.at("height_max"), 0);
  std::set<float> seen;
  const Image &roughness = run.output<Image>("roughness"), &id = run.output<Image>("id");
  for (int y = 0; y < id.height; ++y)
    for (int x = 0; x < id.width; ++x)
      if (inside(id, x, y)) seen.insert(roughness.at(x, y).x());
  EXPECT_EQ(seen, (std::set<float>{0.15f, 0.4f}));
}

TEST(TextureSet, AParticleBelowTheWornBinderEmergesAsItIs) {
  // Its top is 0.4 mm below the plane, the binder is worn by 1 mm.
  const auto run = maps_of(one_ball(0.6), {{"position", "2"},
                                           {"resolution", "200"},
                                           {"finish", "weathered"},
                                           {"relief", "1"},
                                           {"rounding", "0"}});
  const Image &height = run.output<Image>("height"), &color = run.output<Image>("base_color");
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) {
      const double r = std::hypot((x + 0.5) * 0.02 - 2, (y + 0.5) * 0.02 - 2);
      const double sphere = r < 1 ? -1.4 + std::sqrt(1 - r * r) : -2;
      if (std::abs(sphere + 1) < 0.1) continue;  // texels with the edge
      EXPECT_NEAR(height.at(x, y).x(), std::max(-1.0, sphere), 0.004);
      EXPECT_NEAR(color.at(x, y).x(), sphere > -1 ? 0.8f : 0.2f, 1e-5f);
    }
}

TEST(TextureSet, SofterStonesLieDeeperAndVoidsAreOpen) {
  const Settings place = {
      {"position", "2"}, {"resolution", "100"}, {"finish", "honed"}, {"relief", "-0.3"}, {"rounding", "0"}};
  const Image worn = maps_of(one_ball(2), place).output<Image>("height");
  EXPECT_FLOAT_EQ(worn.at(50, 50).x(), -0.3f);
  EXPECT_FLOAT_EQ(worn.at(5, 5).x(), 0);
  // Beside the center the ball ends above the level, and the binder below it stays.
  const double r = std::hypot(0.98, 0.02);
  EXPECT_NEAR(worn.at(50 + 24, 50).x(), std::max(-0.3, -std::sqrt(1 - r * r)), 0.02);

  const auto hole = maps_of(one_ball(2, true), {{"position", "2"}, {"resolution", "100"}});
  EXPECT_NEAR(hole.output<Image>("height").at(50, 50).x(), -1, 0.002);
  EXPECT_EQ(hole.output<Image>("base_color").at(50, 50), Vec3f::Constant(0.2f));
  EXPECT_EQ(hole.output<Image>("id").at(50, 50), Vec3f::Zero());
  EXPECT_FLOAT_EQ(hole.output<Image>("roughness").at(50, 50).x(), 0.9f);
  EXPECT_LT(hole.output<Image>("occlusion").at(50, 50).x(), 0.7f);
}

// Stones whose center is below the face stand out of it as they are; the others leave sockets; between them
// is the face itself.
TEST(TextureSet, AFractureFollowsTheParticles) {
  const Stones s = lattice_of_stones();
  const Settings settings = {
      {"resolution", "240"}, {"position", "1.4"}, {"finish", "broken"}, {"relief", "0.3"}, {"seed", "5"}};
  const auto run = maps_of(s, settings);
  const Image &height = run.output<Image>("height"), &id = run.output<Image>("id");
  double grain = 0;
  for (const double size : s.particles.size) grain += size / 24;
  const texture_set::BrokenFace face(12, 9, 0.05, grain, 0.3, 5);
  const carving::ParticleIndex index(s.particles, s.shapes);
  const auto above_face = [&](int particle) {  // of the image that is nearest to the plane
    const Vec3& p = s.particles.position[particle];
    const double above = p.z() - 1.4;
    return above - 6 * std::round(above / 6) - face.at(p.x(), p.y());
  };
  const auto steep = [&](int x, int y) {  // where a texel may be an average
    for (const auto& [dx, dy] : {std::pair(1, 0), {239, 0}, {0, 1}, {0, 179}})
      if (std::abs(height.at((x + dx) % 240, (y + dy) % 180).x() - height.at(x, y).x()) > 0.19f) return true;
    return false;
  };
  int stones = 0, sockets = 0, between = 0, wrong = 0;
  for (int y = 0; y < 180; ++y)
    for (int x = 0; x < 240; ++x) {
      if (!inside(id, x, y) || steep(x, y)) continue;
      const double u = (x + 0.5) * 0.05, v = (180 - y - 0.5) * 0.05, h = height.at(x, y).x();
      const auto at = [&](double z) { return index.at(Vec3(u, v, 1.4 + z).cast<float>()); };
      const int here = at(h - 2e-3), over = at(h + 2e-3);
      bool right;
      if (id.at(x, y) != Vec3f::Zero()) {
        right = id.at(x, y) == texture_set::id_color(here) && over != here && above_face(here) < 0;
        ++stones;
      } else if (over >= 0) {
        right = here == -1 && above_face(over) > 0 && h < face.at(u, v) + 1e-5;
        ++sockets;
      } else {
        right = std::abs(h - face.at(u, v)) < 1e-5;
        ++between;
      }
      wrong += !right;
    }
  EXPECT_GT(stones, 2000);
  EXPECT_GT(sockets, 1000);
  EXPECT_GT(between, 2000);
  EXPECT_LE(wrong, 30);  // averages beside steps, which are hard to tell from their neighbors
}

TEST(TextureSet, ABrokenFaceHasItsDeviation) {
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const texture_set::BrokenFace face(40, 30, 0.5, 1, 0.3, seed);
    for (int i = 0; i < 80 * 60; ++i) {
      const double mm = face.at(i % 80 * 0.5, i / 80 * 0.5);
      squares += mm * mm / (20 * 80 * 60);
    }
    EXPECT_NEAR(face.at(3.2, 7.1), face.at(43.2, 37.1), 1e-9);
  }
  EXPECT_NEAR(std::sqrt(squares), 0.3, 0.02);
}

TEST(TextureSet, LooseStonesLieOnEachOther) {
  const auto run = maps_of(one_ball(1.5), {{"position", "2"}, {"resolution", "100"}, {"finish", "loose"}});
  const Image& height = run.output<Image>("height");
  for (int y = 2; y < 100; ++y)
    for (int x = 2; x < 100; ++x) {
      const double r = std::hypot((x + 0.5) * 0.04 - 2, (y + 0.5) * 0.04 - 2);
      if (r < 0.9) EXPECT_NEAR(height.at(x, y).x(), -0.5 + std::sqrt(1 - r * r), 0.01);
    }
  EXPECT_LT(height.at(2, 2).x(), -4);  // the ground
}

TEST(TextureSet, ThreadsDoNotChangeTheMaps) {
  const Detail detail = speckle();
  const Settings settings = {{"resolution", "96"}, {"finish", "weathered"}};
  const auto one = maps_of(lattice_of_stones(), settings, &detail, 1),
             four = maps_of(lattice_of_stones(), settings, &detail, 4);
  for (const auto& [name, value] : one.outputs)
    EXPECT_EQ(value.as<Image>().pixels, four.output<Image>(name).pixels) << name;
}

TEST(TextureSet, IdsAreDistinctAndCanBeRead) {
  std::set<std::vector<int>> seen;
  for (int particle = -1; particle < 5000; ++particle) {
    const Vec3f c = 255 * texture_set::id_color(particle);
    const std::vector<int> bytes = {round_nearest(c.x()), round_nearest(c.y()), round_nearest(c.z())};
    EXPECT_TRUE(seen.insert(bytes).second);
    const auto bits = static_cast<std::uint32_t>(bytes[0] + 256 * bytes[1] + 65536 * bytes[2]);
    EXPECT_EQ(static_cast<int>(bits * 0x8b2f51u & 0xffffffu) - 1, particle);
  }
}

Volume colored_volume(bool periodic, bool density) {
  initialize_openvdb();
  Volume v;
  v.resolution = periodic ? Vec3i(8, 8, 8) : Vec3i::Zero();
  auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  auto cover = openvdb::FloatGrid::create(0);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) {
        color->tree().setValue({x, y, z}, openvdb::Vec3s(x / 8.0f, y / 8.0f, 0.5f));
        cover->tree().setValue({x, y, z}, x < 4 ? 1.0f : 0.0f);
      }
  color->setName("Cd");
  cover->setName("density");
  v.grids = {color};
  if (density) v.grids.push_back(cover);
  return v;
}

TEST(TextureSet, AVolumeShowsItsVoxelsAndItsOutlines) {
  const Value volume = Value::of(colored_volume(true, true));
  const auto run =
      test::run_node("TextureSet", {{"volume", volume}},
                     {{"resolution", "8"}, {"finish", "honed"}, {"relief", "0.5"}, {"rounding", "0"}});
  const Image &color = run.output<Image>("base_color"), &height = run.output<Image>("height");
  EXPECT_NEAR(color.at(2, 7).x(), 0.25f, 1e-5f);
  EXPECT_NEAR(color.at(2, 4).y(), 3 / 8.0f, 1e-5f);  // rows from the top
  EXPECT_EQ(height.at(2, 3).x(), 0);
  EXPECT_EQ(height.at(6, 3).x(), -0.5f);
}

TEST(TextureSet, RefusesWhatItCannotShow) {
  const auto code = [](const std::multimap<std::string, Value>& inputs, const Settings& settings = {}) {
    return test::code_of([&] { test::run_node("TextureSet", inputs, settings); });
  };
  const Stones s = one_ball(2);
  const Value particles = Value::of(s.particles), shapes = Value::of(s.shapes);
  EXPECT_EQ(code({}), "missing-input");
  EXPECT_EQ(code({{"particles", particles}}), "missing-input");
  EXPECT_EQ(code({{"volume", Value::of(colored_volume(false, true))}}), "not-periodic");
  const Value colors = Value::of(colored_volume(true, false));
  EXPECT_EQ(code({{"volume", colors}, {"shapes", shapes}}), "two-sources");
  EXPECT_EQ(code({{"volume", colors}}, {{"finish", "weathered"}, {"resolution", "8"}}), "no-such-grid");
  EXPECT_EQ(code({{"volume", colors}}, {{"finish", "broken"}}), "missing-input");
  const std::multimap<std::string, Value> both = {{"particles", particles}, {"shapes", shapes}};
  const auto parameter = [](const std::multimap<std::string, Value>& inputs, const Settings& settings) {
    try {
      test::run_node("TextureSet", inputs, settings);
    } catch (const Error& e) {
      return e.diagnostic().code + " of " + e.diagnostic().parameter;
    }
    return std::string();
  };
  EXPECT_EQ(parameter(both, {{"position", "5"}}), "bad-offset of position");
  EXPECT_EQ(parameter({{"volume", colors}}, {{"finish", "honed"}, {"relief", "-1"}}),
            "no-such-grid of finish");
  EXPECT_EQ(code(both, {{"finish", "honed"}, {"relief", "3"}}), "bad-value");
  EXPECT_EQ(code(both, {{"finish", "honed"}, {"rounding", "1"}}), "bad-value");
}

TEST(TextureSet, RefusesMapsThatDoNotFitIntoMemory) {
  const Stones s = one_ball(2);
  ComputeRequest request;
  request.type = test::all_nodes().find("TextureSet");
  request.inputs = {{"particles", {Value::of(s.particles)}}, {"shapes", {Value::of(s.shapes)}}};
  request.parameters = effective_parameters(*request.type, {{"resolution", std::int64_t{16384}}});
  request.memory = std::uint64_t{1} << 30;
  try {
    compute_node(std::move(request));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "too-large");
    EXPECT_EQ(e.diagnostic().parameter, "resolution");
  }
}

}  // namespace
}  // namespace terrazzo
