// Colors and textures of one picture's materials.
#pragma once

#include <vector>

#include "nodes/data/linear.h"
#include "runtime/random.h"

namespace terrazzo::synthetic_photo {

// A texture in space: mean color with grain, blotches, veins or layers.
struct Texture {
  Vec3f color = Vec3f::Zero(), second = Vec3f::Zero();  // scene-linear
  enum class Kind { Plain, Grain, Blotches, Veins, Layers, Cells } kind = Kind::Plain;
  double scale = 10;    // canvas pixels
  double strength = 0;  // how far `second` replaces `color`, 0 to 1
  double speckle = 0;   // relative amplitude of fine grain
  double speckle_scale = 2;
  std::uint64_t seed = 0;
  Vec3f operator()(const Vec3& p) const;
};

class PhotoPalette {
 public:
  // `gray`: as under an electron microscope or in a CT slice.
  PhotoPalette(Random& random, bool gray);
  // The soil or binder.
  Texture ground(Random&) const;
  // A particle `radius` canvas pixels wide.
  Texture particle(Random&, double radius) const;
  const Vec3f& ground_color() const { return ground_; }

 private:
  // `vivid`: how likely it has a strong hue.
  Vec3f natural(Random&, double vivid) const;
  Texture texture(Random&, const Vec3f& color, double radius, double liveliness) const;
  bool gray_ = false;
  Vec3f ground_ = Vec3f::Zero();
  std::vector<Vec3f> kinds_;
  double vivid_ = 0, chroma_ = 0.02, spread_ = 0.05, liveliness_ = 0.5, near_ground_ = 0;
};

}  // namespace terrazzo::synthetic_photo
