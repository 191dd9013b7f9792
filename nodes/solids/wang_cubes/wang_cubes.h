// Wang cubes: tiles with colored faces that continue each other wherever the colors of their faces agree.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/solids/patch_fill/fill.h"

namespace terrazzo::wang_cubes {

using patch_fill::Torus;

// Colors of a cube's faces, 0 …: the lower and the upper face across x, y and z.
struct FaceColors {
  std::array<int, 3> low{}, high{};
  auto operator<=>(const FaceColors&) const = default;
};

// Cubes in a periodic lattice, with random face colors. Equal cubes are kept apart where possible. Cube (z·ny
// + y)·nx + x; neighbors share a face.
struct Lattice {
  Vec3i cubes = Vec3i::Ones();
  std::vector<FaceColors> faces;
};
Lattice random_lattice(const Vec3i& cubes, int colors, std::uint64_t seed);

struct CubeOptions {
  int colors = 2;
  int rim = 2;  // voxels on each side of a face that belong to the face
  patch_fill::FillOptions fill;
};

// The cubes that a lattice needs, each as large as the solid.
struct CubeSet {
  std::vector<FaceColors> faces;   // of each cube, all different
  std::vector<Torus<Vec3f>> cube;  // scene-linear
  std::vector<std::size_t> at;     // which one is at each place of the lattice
};

// `solid` tiles and has scene-linear colors. The cube whose faces all have color 0 is the solid itself. Each
// other color of faces across an axis has one content, which loses its weight within 2 rims beyond. Along
// their edges all cubes are the solid, within `rim` voxels of two faces. Throws Error "one-color".
CubeSet make_cubes(const Torus<Vec3f>& solid, const Lattice&, const CubeOptions&, const Work&);

// All cubes side by side. The result tiles.
Torus<Vec3f> assemble(const CubeSet&, const Lattice&);

// The largest correlation of the colors with themselves one cube further along x, y or z: 1 if all cubes are
// equal, 0 without repetition. Along an axis with one cube there is nothing to compare.
double repetition(const Torus<Vec3f>& colors, const Vec3i& cubes);

}  // namespace terrazzo::wang_cubes
