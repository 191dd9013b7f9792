// Solids and meshes for the tests of Bake.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/data/detail.h"
#include "nodes/data/volume.h"
#include "nodes/textures/bake/bake_maps.h"
#include "runtime/random.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo::bake_cases {

using Settings = std::map<std::string, std::string>;

struct BakedSolid {
  Particles particles;
  Shapes shapes;
};

// Balls on a lattice with random shifts, which do not overlap.
inline BakedSolid balls_on_a_lattice() {
  BakedSolid s;
  s.shapes.shapes = {measure_shape("ball", geodesic_sphere(3))};
  s.particles.box = Vec3(12, 9, 6);
  s.particles.resize(24);
  for (int i = 0; i < 24; ++i) {
    Random random(7, 1, static_cast<std::uint64_t>(i));
    s.particles.position[i] = 3.0 * Vec3(i % 4, i / 4 % 3, i / 12) + 1.3 * Vec3::Ones();
    for (int k = 0; k < 3; ++k) s.particles.position[i][k] += random.uniform(-0.25, 0.25);
    s.particles.cls[i] = i % 3;
    s.particles.scale[i] = random.uniform(0.9, 1.2);
    s.particles.size[i] = 2 * s.particles.scale[i];
    s.particles.color[i] =
        Vec3f(random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), random.uniform(0.1, 0.9));
  }
  s.particles.binder_color = Vec3f(0.3f, 0.25f, 0.2f);
  return s;
}

inline Detail grain() {
  Detail d;
  d.pixel_size = 0.1;
  d.size = 16;
  for (std::uint64_t k = 0; k < 2; ++k) {
    Detail::Phase phase;
    for (std::uint64_t i = 0; i < 16 * 16 * 16; ++i)
      phase.tile.push_back(Vec3f::Constant(static_cast<float>(0.05 * Random(1, k, i).normal())));
    d.phases.push_back(std::move(phase));
  }
  return d;
}

// A rectangle at height z with its picture's upper left corner at (x0, y1), over part of the texture.
inline Shape rectangle(const Vec2& low, const Vec2& high, double z, float u0 = 0, float v0 = 0, float u1 = 1,
                       float v1 = 1) {
  Shape s;
  s.name = "plane";
  s.mesh.vertices = {
      {low.x(), low.y(), z}, {high.x(), low.y(), z}, {high.x(), high.y(), z}, {low.x(), high.y(), z}};
  s.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Eigen::Vector2f a(u0, v1), b(u1, v1), c(u1, v0), d(u0, v0);
  s.uv = {{a, b, c}, {a, c, d}};
  return s;
}

inline Shapes only(Shape shape) {
  Shapes s;
  s.shapes.push_back(std::move(shape));
  return s;
}

inline std::multimap<std::string, Value> inputs_of(const Shape& mesh, const BakedSolid& s,
                                                   const Detail* detail = nullptr) {
  std::multimap<std::string, Value> inputs = {{"mesh", Value::of(only(mesh))},
                                              {"particles", Value::of(s.particles)},
                                              {"shapes", Value::of(s.shapes)}};
  if (detail) inputs.emplace("detail", Value::of(*detail));
  return inputs;
}

inline test::NodeRun bake_of(const Shape& mesh, const BakedSolid& s, const Settings& parameters,
                             const Detail* detail = nullptr, int threads = 0) {
  return test::run_node("Bake", inputs_of(mesh, s, detail), parameters, {}, threads);
}

inline Volume waves(bool periodic, bool density) {
  initialize_openvdb();
  Volume v;
  v.resolution = periodic ? Vec3i(16, 16, 16) : Vec3i::Zero();
  auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  auto cover = openvdb::FloatGrid::create(0);
  const auto wave = [](int i) {
    return 0.5f + 0.4f * static_cast<float>(std::sin(std::numbers::pi * (i + 0.5) / 8));
  };
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y)
      for (int z = 0; z < 16; ++z) {
        color->tree().setValue({x, y, z}, openvdb::Vec3s(wave(x), wave(y), wave(z)));
        cover->tree().setValue({x, y, z}, x < 8 ? 1.0f : 0.0f);
      }
  color->setName("Cd");
  cover->setName("density");
  color->setTransform(voxel_transform(1));
  cover->setTransform(voxel_transform(1));
  v.grids = {color};
  if (density) v.grids.push_back(cover);
  return v;
}

}  // namespace terrazzo::bake_cases
