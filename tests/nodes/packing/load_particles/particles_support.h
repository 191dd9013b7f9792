// Particles with every kind of field, and their file.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "nodes/data/particles.h"
#include "tests/support/run_node.h"
#include "tests/support/stored_values.h"

namespace terrazzo::test {

// Three particles in a box that is no cube, with numbers that text easily changes.
inline Particles awkward_particles() {
  Particles p;
  p.box = Vec3(1.0 / 3, 2, 1e300);
  p.resize(3);
  p.shape = {0, 2147483647, 1};
  p.cls = {3, 0, 7};
  p.position = {Vec3(0.1 + 0.2, -0.0, 5e-324), Vec3(0, 1e-17, 1e299), Vec3(1.0 / 3, 2, 123456789.123456789)};
  p.orientation = {Quat(1, 0, 0, 0), Quat(-0.5, 0.5, -0.5, 0.5), Quat(0, 0.6, -0.0, 0.8)};
  p.scale = {1e-300, 3, 0.1};
  p.size = {2, 1e17, 0.7};
  p.color = {Vec3f(0.1f, 16777216, 1e-40f), Vec3f(-0.0f, 1, 3.4e38f), Vec3f(0.3f, -2, 1.0f / 3)};
  p.binder_color = Vec3f(0.7f, 0, 1e-20f);
  p.voids = {0, 1, 0};
  return p;
}

inline std::filesystem::path file_with(const std::string& text) {
  const auto path = temporary_folder() / "packing.json";
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

inline Particles loaded(const std::filesystem::path& file) {
  return run_node("LoadParticles", {}, {{"path", file.string()}}).output<Particles>("particles");
}

}  // namespace terrazzo::test
