// A scene and the view of one frame: the input of both renderers, in their own units.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nodes/common/geometry/camera.h"
#include "nodes/data/image.h"
#include "nodes/volumes/render_volume/bricks.h"
#include "nodes/volumes/render_volume/solid_texture.h"
#include "nodes/volumes/render_volume/tissue.h"

namespace terrazzo::render_volume {

constexpr int kScales = 3;

struct Look {
  int width = 512, height = 512, samples = 1;  // pixels; rays per pixel along each of its edges
  double step = 1;                             // along a ray, in shortest edges of a voxel
  bool textured = true;                        // else each texture's mean color
  std::array<double, kScales> scales = {10, 1, 0.1}, weights = {3, 1, 1};
  Turning turning = Turning::Random;
  Vec2 window = Vec2(-1000, 1000);      // densities at which the paper's `int` is 0 and 1
  double modulation = 1;                // of color by density, eq. 7; not of noise
  double opacity = 1;                   // factor on every tissue's opacity
  double ambient = 0.38;                // brightness of the light from all sides; the lamp's is 0.67
  double translucency = 0;              // share of the lamp's light that enters the tissues
  double penetration = 4;               // mm on which that light falls to 1/e, unless a tissue has its own
  Vec3 lamp = Vec3(-0.45, 0.55, 0.75);  // direction to it: right, up, towards the viewer
  double skin_noise = 0.15, skin_scale = 3;                    // fraction of the color; mm
  std::array<Vec3f, 2> clip = {Vec3f::Zero(), Vec3f::Ones()};  // region kept, as fractions of the edges
  int up = 2;                                                  // the axis that points up in the picture
  double azimuth = -41, elevation = 20, zoom = 1;              // azimuth and elevation in degrees
  Vec3f background = Vec3f::Constant(0.8f);
  std::uint64_t seed = 1;
  bool skip_empty = true;  // else every sample is taken, for comparison
};

struct Scene {
  ScanField scan;
  std::vector<Tissue> tissues;
  DensityIntervals intervals;
  std::vector<int> texture;  // per tissue: index into textures, −1 if none
  std::vector<SolidTexture> textures;
  Look look;
  // Bounds of the visible voxels as fractions of the edges; the whole volume if none are visible.
  Eigen::AlignedBox3f seen;

  // Assigns a texture to each tissue that asks for one, in order. Throws Error "missing-texture",
  // "spare-texture".
  Scene(ScanField, std::vector<Tissue>, std::vector<SolidTexture>, const Look&);
};

// The appearance of a tissue in one frame.
struct TissueLook {
  Vec3f color = Vec3f::Zero();  // if there is no texture
  int texture = -1;
  bool noise = false;
  std::array<Placement, kScales> at;  // from positions as in Bricks
  std::array<float, kScales> weight{};
  float fixed = 0;  // extinction per mm, if it does not depend on density
  bool by_density = false;
  float light_extinction = 0;  // per mm, of the lamp's light within tissues
  float threshold = 0;         // `int` at the lower end of its range
  float modulation = 0;        // of color by density, eq. 7; 0 with noise, which the paper exempts as skin
};

// One frame. Positions are those of Bricks; directions are per mm.
struct Frame {
  Camera camera;             // in mm, with the volume's middle at 0
  Vec3f low, high;           // bounds of the region kept
  Vec3f per_mm;              // positions per mm along each axis
  Vec3f middle;              // the position of the volume's middle
  Vec3f light;               // towards the lamp, in mm
  float step = 1;            // mm
  float reference_step = 1;  // mm: a thousandth of the longest edge, the length to which opacities refer
  float int_scale = 1, int_offset = 0;  // int = scale · stored + offset
  float soft_gradient = 1;  // gradient in stored units per mm at which surface shading has half its weight
  std::vector<TissueLook> tissues;
};
Frame frame_of(const Scene&, double azimuth);

// Work done for a frame.
struct FrameCounts {
  std::uint64_t rays = 0, samples = 0, pieces = 0, lookups = 0;
  FrameCounts& operator+=(const FrameCounts& o) {
    rays += o.rays;
    samples += o.samples;
    pieces += o.pieces;
    lookups += o.lookups;
    return *this;
  }
};

// Renders on the CPU. Returns width · height scene-linear colors, rows from the top. The result has the same
// bits on any number of threads.
std::vector<Vec3f> march(const Scene&, const Frame&, const Bricks&, FrameCounts&, const Work& = {});

}  // namespace terrazzo::render_volume
