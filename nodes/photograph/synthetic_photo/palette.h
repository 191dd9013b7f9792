// Colors and textures of one picture's materials.
#pragma once

#include <vector>

#include "nodes/data/linear.h"
#include "runtime/random.h"

namespace terrazzo::synthetic_photo {

// A texture in space: mean color with grain, blotches, veins or layers, and what weather does to a stone.
struct Texture {
  Vec3f color = Vec3f::Zero(), second = Vec3f::Zero();  // scene-linear
  enum class Kind { Plain, Grain, Blotches, Veins, Layers, Cells } kind = Kind::Plain;
  double scale = 10;    // canvas pixels
  double strength = 0;  // how far `second` replaces `color`, 0 to 1
  double speckle = 0;   // relative amplitude of fine grain
  double speckle_scale = 2;
  // Of a loose stone; p = 0 is its center.
  Vec3 tone = Vec3::Zero();                // relative change of lightness per canvas pixel
  double mottle = 0;                       // relative amplitude of clouds in several octaves
  double mottle_scale = 10;                // size of the largest clouds, canvas pixels
  double flecks = 0;                       // share of the surface with small light or dark flecks
  double fleck_scale = 3;                  // canvas pixels
  float fleck_gain = 1;                    // factor on their color
  Vec3 vein = Vec3::Zero();                // unit normal of a sheet of another mineral; zero: none
  double vein_offset = 0, vein_width = 0;  // canvas pixels
  Vec3f vein_color = Vec3f::Zero();
  std::uint64_t seed = 0;
  Vec3f operator()(const Vec3& p) const;
};

enum class Surroundings {
  Workshop,    // sections: any colors
  Microscope,  // sections of two or three smooth phases
  Outdoors,    // sand, clay and stones: mostly dull colors
  Outcrop,     // stones that are as light as the soil they lie in, and hardly differ from it in hue
};

class PhotoPalette {
 public:
  // `gray`: as under an electron microscope or in a CT slice.
  PhotoPalette(Random& random, Surroundings, bool gray);
  // The soil or binder.
  Texture ground(Random&) const;
  // Smooth soil or mud, near the color of the ground.
  Texture clay(Random&) const;
  // A particle `radius` canvas pixels wide.
  Texture particle(Random&, double radius) const;
  // The same, weathered: clouds, flecks, a lighter side, sometimes a vein.
  Texture stone(Random&, double radius) const;
  const Vec3f& ground_color() const { return ground_; }

 private:
  void make_outcrop(Random&);
  void make_phases(Random&);
  // `vivid`: how likely it has a strong hue.
  Vec3f natural(Random&, double vivid) const;
  Texture texture(Random&, const Vec3f& color, double radius, double liveliness) const;
  bool gray_ = false;
  Surroundings where_ = Surroundings::Workshop;
  Vec3f ground_ = Vec3f::Zero();
  std::vector<Vec3f> kinds_;
  double vivid_ = 0, hue_ = 0.3, chroma_ = 0.02, spread_ = 0.05, liveliness_ = 0.5, near_ground_ = 0;
};

}  // namespace terrazzo::synthetic_photo
