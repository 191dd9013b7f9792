// The outsides of photographed stones on the particles of a packing.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::residual {

// Every particle wears the skin of a stone of about its color and size. If that is the stone from which its
// shape was traced, and it lies about as in the photograph, the skin lies in its place. That of another stone
// is projected along z, the direction in which the photograph looked: it is moved and stretched so that the
// ellipse of the stone's silhouette falls on that of the particle's, with as little stretching as possible
// (the optimal transport between two ellipses), mirrored or not, and turned if it would be stretched far.
// Skins that need little stretching, and above all no enlarging, are preferred, those of stones that nothing
// hides, and those that few others wear. On bodies with flat faces of their own, only the texture of a skin
// is laid, as large as it was.
//
// Where a skin shows relief rather than stains (Detail::Relief), it is lit from where the light stands, not
// from where it stood when the stone was photographed. A slope's light is linear in it (Pentland 1990): the
// slope along the light is the part of the shade that is relief, the slope across it follows since both
// belong to one height.
class Skins {
 public:
  // `footprint`: edge of the pixels that will show the skins, mm; skins are smoothed for it. `light`: toward
  // where the light stands, along the packing's x and y, of any length; nothing: as photographed. Without
  // skins, particles are bare.
  Skins(const Detail&, const Particles&, const Shapes&, double footprint, const std::optional<Vec2>& light,
        const Work& = {});

  // The soil at a point in mm, where it otherwise has this color: the photograph's, which repeats
  // seamlessly. Only if there is such a photograph.
  bool has_ground() const { return !ground_.shade.empty(); }
  Vec3f ground(const Vec3f& mm, const Vec3f& color) const;

  bool bare(std::size_t particle) const { return worn_[particle].skin < 0; }
  // How much of the photograph's fine grain a skin lacks because it is enlarged, from 0 to 1.
  float lost_grain(int particle) const { return worn_[particle].lost_grain; }
  // The color at a point in mm of a particle that is not bare and otherwise has this color; scene-linear.
  Vec3f at(const Vec3f& mm, int particle, const Vec3f& color) const;

 private:
  // Shade; then the part of its luminance that is relief, and what that would be if the light stood a quarter
  // turn counterclockwise from where it did.
  using Texel = Eigen::Matrix<float, 5, 1>;
  struct Picture {
    int width = 0, height = 0;
    std::vector<Texel> texels;
  };
  struct Worn {
    int skin = -1;
    float lost_grain = 0;
    int level = 0;                                    // of the skin's pictures
    Eigen::Vector2f relit = Eigen::Vector2f::Zero();  // of the last two numbers of texels, added to the shade
    // Pixels to the right and downwards per mm from the particle's position, and at that position.
    Eigen::Matrix<float, 2, 3> to_skin = Eigen::Matrix<float, 2, 3>::Zero();
    Eigen::Vector2f start = Eigen::Vector2f::Zero();
    Vec3f center = Vec3f::Zero();  // the particle's position, mm
  };
  static Picture with_relief(const Detail::Skin&, const Detail::Relief&);
  static Picture halved(const Picture&);
  static void remove_faces(Detail::Skin&);
  void take_pictures(const Detail::Relief&, bool reduced, const Work&);
  void fit_level(Worn&, double footprint) const;
  void light_up(Worn&, const Eigen::Vector2f& photographed, const std::optional<Vec2>& light) const;
  std::optional<Worn> own_skin(const Shape&, const Particles&, std::size_t particle) const;
  Worn choose(std::size_t particle, const Particles&, const Eigen::Matrix2d& spread,
              const std::optional<Worn>& own) const;

  Vec3f box_;
  double pixel_size_;
  Detail::Ground ground_;
  std::vector<Detail::Skin> skins_;             // without their shades
  std::vector<std::vector<Picture>> pictures_;  // of each, each half as large as the one before
  std::vector<Vec3f> oklab_;                    // colors of skins
  std::vector<double> hidden_;                  // what it costs to wear each, because others hide a part
  std::map<std::int32_t, int> of_profile_;      // number of the skin
  std::vector<double> covers_;                  // squares of the sizes of the particles that wear each skin
  bool faceted_ = false;                        // whether all bodies have flat faces of their own
  double usual_cover_ = 0;                      // on average
  std::vector<Worn> worn_;                      // by each particle
};

// Leaves out skins, soil, and the broad light and shade by which a photograph shows the form and the shadows
// of stones. The hue stays.
Detail without_light(Detail);

}  // namespace terrazzo::residual
