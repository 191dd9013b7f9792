// What is rendered, and how one frame of it is seen: all that either renderer needs, in its own units.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nodes/common/camera.h"
#include "nodes/data/image.h"
#include "nodes/render_volume/bricks.h"
#include "nodes/render_volume/solid_texture.h"
#include "nodes/render_volume/tissue.h"

namespace terrazzo::render_volume {

constexpr int kScales = 3;

struct Look {
  int width = 512, height = 512, samples = 1;  // pixels; rays a pixel, in a square
  double step = 1;                             // of a ray, in voxels' shortest edges
  bool textured = true;                        // else every texture's mean colour
  std::array<double, kScales> scales = {10, 1, 0.1}, weights = {3, 1, 1};
  Turning turning = Turning::Random;
  Vec2 window = Vec2(-1000, 1000);           // densities at which the paper's `int` is 0 and 1
  double modulation = 1;                     // of colour by density, eq. 7
  double opacity = 1;                        // times every tissue's
  double skin_noise = 0.15, skin_scale = 3;  // share of the colour, mm
  std::array<Vec3f, 2> clip = {Vec3f::Zero(), Vec3f::Ones()};  // what is kept, in shares of the edges
  int up = 2;                                                  // the axis that points up in the picture
  double azimuth = -41, elevation = 20, zoom = 1;              // degrees
  Vec3f background = Vec3f::Constant(0.8f);
  std::uint64_t seed = 1;
  bool skip_empty = true;  // else every sample is taken: for comparison
};

struct Scene {
  ScanField scan;
  std::vector<Tissue> tissues;
  DensityIntervals intervals;
  std::vector<int> texture;  // of each tissue: into textures, −1 without
  std::vector<SolidTexture> textures;
  Look look;
  Eigen::AlignedBox3f seen;  // of the voxels that a class holds, in shares of the edges; all where none is

  // Gives the tissues that ask for a texture one each, in order. Throws Error "missing-texture",
  // "spare-texture".
  Scene(ScanField, std::vector<Tissue>, std::vector<SolidTexture>, const Look&);
};

// What a tissue looks like in one frame.
struct TissueLook {
  Vec3f color = Vec3f::Zero();  // without a texture
  int texture = -1;
  bool noise = false;
  std::array<Placement, kScales> at;  // from positions as in Bricks
  std::array<float, kScales> weight{};
  float fixed = 0;  // extinction a voxel step, where it does not depend on density
  bool by_density = false;
  float threshold = 0;  // `int` at its lower bound
};

// One frame. Positions are those of Bricks; directions are per mm.
struct Frame {
  Camera camera;                        // in mm, the volume's middle at 0
  Vec3f low, high;                      // of what is kept
  Vec3f per_mm;                         // positions per mm along each axis
  Vec3f middle;                         // the position of the volume's middle
  Vec3f light;                          // towards the lamp, in mm
  float step = 1;                       // mm
  float reference_step = 1;             // mm: a thousandth of the longest edge, to which opacities refer
  float int_scale = 1, int_offset = 0;  // int = scale · stored + offset
  float soft_gradient = 1;              // stored numbers per mm at which a surface counts half
  std::vector<TissueLook> tissues;
};
Frame frame_of(const Scene&, double azimuth);

// What was done for a frame.
struct FrameCounts {
  std::uint64_t rays = 0, samples = 0, pieces = 0, lookups = 0;
  FrameCounts& operator+=(const FrameCounts& o) {
    rays += o.rays, samples += o.samples, pieces += o.pieces, lookups += o.lookups;
    return *this;
  }
};

// On the CPU. Appends nothing: gives width · height colours, scene-linear, rows from the top. The same bits
// on any number of threads.
std::vector<Vec3f> march(const Scene&, const Frame&, const Bricks&, FrameCounts&, const Work& = {});

}  // namespace terrazzo::render_volume
