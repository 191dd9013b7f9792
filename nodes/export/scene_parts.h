// What scenes for Mitsuba and pbrt have in common: particles grouped by shape and color, meshes in files
// beside the scene, a camera, and the binder as a medium.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// Both programs give a color to a group of instances, not to a single one.
struct InstanceGroup {
  std::size_t shape = 0;
  int color = 0;
};

// The binder: the share of each voxel that no particle fills.
struct BinderMedium {
  VoxelBox box;
  std::vector<float> density;  // 0 to 1, x fastest
  double extinction = 0;       // per mm where the density is 1
};

struct Scene {
  const Particles* particles = nullptr;
  const Shapes* shapes = nullptr;
  std::vector<Vec3f> colors;            // scene-linear
  std::vector<InstanceGroup> groups;    // in use
  std::vector<int> group;               // of each particle; −1 for voids
  std::vector<std::string> mesh_files;  // of each shape, relative to the scene; empty if unused
  const BinderMedium* binder = nullptr;
  std::string binder_file;  // relative to the scene
  std::string provenance;   // JSON, or empty

  Vec3 center() const { return particles->box / 2; }
  Vec3 eye() const;  // of the camera, which sees the whole box; z is up
};

// Degrees, of the shorter side of the picture.
inline constexpr double kSceneViewAngle = 30;
inline constexpr int kSceneWidth = 1024;
inline constexpr int kSceneHeight = 1024;
inline constexpr int kSceneSamples = 64;

// At most `most_colors` colors (color_classes). Mesh files are named STEM_0.ply and so on, by shape. Throws
// the errors of instances_of, and Error "bad-names" if `stem` contains quotes, backslashes or control
// characters.
Scene scene_of(const Particles&, const Shapes&, const std::string& stem, int most_colors);

// From the grid `density` of a volume. Light passes about 1/20 of the longest edge of the box between two
// collisions. Throws Error "no-such-grid", "too-large", and those of voxel_box().
BinderMedium binder_medium(const Volume&, std::uint64_t memory, const Work&);

// A shape as binary PLY with normals, as render_mesh() makes them.
void write_render_ply(const std::filesystem::path&, const Shape&);

// Rotation, scale and position of a particle, row by row.
std::array<double, 16> instance_matrix(const Particles&, std::size_t i);

}  // namespace terrazzo::exporting
