// A block of a packing broken across by a rough face: which particles stay, and where the face is. See
// fracture_solid.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo::carving {

class BrokenBlock {
 public:
  struct Image {  // of a particle, periodic
    std::size_t particle;
    std::uint32_t mesh;
    Eigen::Matrix3f turn;
    bool stays;  // else it leaves a socket
  };
  static constexpr int kFaceSteps = 480;  // fine enough that facets do not shade each other in grazing light

  // Throws the errors of check_shown.
  BrokenBlock(const Particles&, const Shapes&, double level, double roughness, std::uint64_t seed);

  // Of the face, in world units.
  float height(float x, float y) const;
  // The face as (kFaceSteps + 1)² vertices, x fastest, wider than the block. Everything below it is the
  // block.
  Shape under_the_face() const;

  // The images of particles that reach into the block and are kept or leave sockets, in pairs.
  const std::vector<Image>& images() const { return images_; }
  const std::vector<RayScene::Instance>& instances() const { return instances_; }
  const Vec3f& size() const { return size_; }  // of the block, world units
  float top() const { return top_; }           // of the highest particle that stays
  float longest() const { return longest_; }   // mm per world unit

 private:
  double level_, roughness_;
  std::uint64_t seed_;
  float longest_ = 1, top_ = 0;
  Vec3f size_;
  std::vector<Image> images_;
  std::vector<RayScene::Instance> instances_;
};

}  // namespace terrazzo::carving
