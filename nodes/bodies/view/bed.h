// A bed of stones: a packing cut at a height, without the stones above, seen from above.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/bodies/carving/ray_mesh.h"
#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/indices.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::view {

// Where the packing is cut, and what the picture shows of it.
struct BedPlace {
  double height = 0;           // mm; stones that are wholly above it are taken away
  Vec2 corner = Vec2::Zero();  // mm, the picture's lower left corner; x to the right, y upwards
};

// Soil that fills the bed up to the cut.
struct BedSoil {
  double cell = 0;     // mm, of the cells whose cover is counted; coarser in large pictures
  double covered = 0;  // the share of the picture that stones cover
};

// The meshes of all shapes, which many beds can use.
struct StoneMeshes {
  std::vector<carving::RayMesh> bodies;
  std::vector<carving::RayScene::Triangles> triangles;
  std::vector<double> radius;  // mm, of the sphere around the origin that holds the mesh

  // Throws the errors of render_mesh.
  explicit StoneMeshes(const Shapes&);
  // Diameter in mm of the largest particle's sphere. Throws Error "no-particles" if all are voids.
  double largest(const Particles&) const;
};

// Whether no particle crosses the upper face of the box, as in a bed of stones that fell.
bool has_top(const Particles&, const Shapes&);

// Heights evenly spaced over one period of the box, from a random start, and random corners. A packing with a
// top is seen from there.
std::vector<BedPlace> choose_places(int pictures, const Particles&, const Shapes&, std::uint64_t seed);

// A point of a surface.
struct BedPoint {
  int stone = -1;  // number in the bed; −1: the soil
  Vec3f at = Vec3f::Zero();
  Vec3f face = Vec3f::UnitZ();    // unit normal of the surface itself
  Vec3f normal = Vec3f::UnitZ();  // unit normal for shading
};

// Positions are in mm from the picture's lower left corner; z is the height above the cut. Every particle
// that is no void lies in the bed with its copy within one period below the cut, with the one above if that
// reaches the cut, and with all copies along x and y whose centers are in the picture or in a margin around
// it. Soil holds stones only up to the exposure at which they cover their share.
class Bed {
 public:
  // `picture`: width and height, mm; `margin`: mm; `soil` may be null. The meshes must outlive the bed.
  // Throws Error "too-many-particles" and "bad-number".
  Bed(const Particles&, const StoneMeshes&, const BedPlace&, const Vec2& picture, double margin,
      const BedSoil* soil, const Work& = {});

  // The first stone below a point of the picture.
  bool below(float x, float y, BedPoint&) const;
  bool hides(const Vec3f& origin, const Vec3f& direction) const;
  // The same for stones that are nearer than `reach`, mm.
  bool hides(const Vec3f& origin, const Vec3f& direction, float reach) const;

  int count() const { return count_of(stones_); }
  int particle(int stone) const { return stones_[stone].particle; }
  // The point's place in the packing, mm: in the particle's own copy, or, in the soil, anywhere in space.
  Vec3f in_packing(const BedPoint&) const;
  double depth() const { return depth_; }  // mm, one period
  float largest() const { return top_; }   // mm, diameter of the largest stone's sphere

 private:
  struct Stone {
    int particle = 0;
    std::uint32_t mesh = 0;
    Eigen::Matrix3f turn;
    Vec3f to_packing;  // mm, added to positions
    float reach;       // mm, from its center down to its lowest point
  };
  void add_copies(const Particles&, int particle, const Vec2& picture, double margin,
                  std::vector<carving::RayScene::Instance>&);
  void leave_in_soil(std::vector<carving::RayScene::Instance>&, const Vec2& picture, const BedSoil&,
                     const Work&);

  const StoneMeshes& meshes_;
  Vec3 origin_;  // of positions, in the packing
  double depth_;
  float top_ = 0;  // above all stones: the largest one's diameter
  std::vector<Stone> stones_;
  std::unique_ptr<carving::RayScene> scene_;
};

}  // namespace terrazzo::view
