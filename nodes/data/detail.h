// Detail: what a photograph shows beyond the flat colors of its binder and particles, as a solid.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/value.h"

namespace terrazzo {

// Offsets are added to sRGB-encoded colors. Those of particles are multiplied by particle_scale() first:
// light stones show more of the same grain than dark ones.
struct Detail {
  // `encoded`: the particle's sRGB-encoded color. The constant limits the detail of dark particles.
  static float particle_scale(const Vec3f& encoded) { return encoded.cwiseMax(0.0f).mean() + 0.15f; }

  // Mean offsets at i + ½ pixels from the nearest outline, if that is the outline of a profile of this size.
  // The last one holds beyond.
  struct Rim {
    float size = 0;  // √(4A/π), mm
    std::vector<Vec3f> offset;
    // What the photograph's light adds, times the component to the right and upwards of the outline's outward
    // normal; both are empty, or as long as offset. The last ones hold beyond.
    std::vector<Vec3f> right, up;
  };
  // The value at a distance in pixels, between those at i + ½ pixels; the first and the last one hold beyond.
  // `values` must not be empty.
  template <class T>
  static T at_distance(const std::vector<T>& values, float distance) {
    const float at = std::clamp<float>(distance - 0.5f, 0.0f, values.size() - 1);
    const std::size_t k = at;
    const float t = at - static_cast<float>(k);
    return t > 0 ? T((1 - t) * values[k] + t * values[k + 1]) : values[k];
  }

  // The offset at a distance in pixels from the outline of a profile, between distances linearly, between
  // sizes by their logarithm. `size`: mm; 0 if it is unknown, which takes the middle one of the rims.
  static Vec3f rim_at(const std::vector<Rim>&, float distance, float size);
  // What light adds there. `normal`: the outline's, to the right and upwards in the picture.
  static Vec3f light_at(const std::vector<Rim>&, float distance, float size, const Eigen::Vector2f& normal);

  struct Phase {
    Vec3f color = Vec3f::Zero();  // mean of the phase, scene-linear
    // Standard deviation along each axis of the slope of lightness across a particle: the offset at a
    // distance of one radius from its center. 0 for the binder.
    float slope = 0;
    // Mean slope of lightness across a profile, to the right and upwards in the photograph, from its light:
    // the offset at a distance of one radius from the center. 0 for the binder.
    Eigen::Vector2f tilt = Eigen::Vector2f::Zero();
    // Beside profiles of different sizes, ascending; none if empty.
    std::vector<Rim> rims;
    // Factors of the tile and of what is broad at i + ½ pixels from the nearest outline, and in particles
    // others of the tile alone. The last one holds beyond; 1 if empty.
    std::vector<float> gain, grain_gain;
    std::vector<Vec3f> tile;   // the grain: size³ offsets, x fastest; tiles
    std::vector<Vec3f> broad;  // what is larger than grain, added to it; empty: nothing
  };
  // Two zones of the binder. A Gaussian field of deviation 1 with the covariance Σ variance · exp(−r² / 4
  // sigma²) is below a level in the dark one: in pictures `level_by_width`, elsewhere `level`, and
  // `mean_level` where no distance is known.
  struct Zones {
    std::vector<float> sigma, variance;  // pixels; the variances' sum is 1
    std::vector<float> level;            // at i + ½ pixels from the nearest outline; empty: no zones
    float mean_level = 0;                // with the share of the dark zone in the whole binder
    std::vector<float> level_by_width;   // where the binder is i + ½ pixels wide, see residual::binder_width
    Vec3f dark = Vec3f::Zero(), light = Vec3f::Zero();  // offsets
    float dark_contrast = 1, light_contrast = 1;        // factors of the tile
  };
  // The camera's noise, which belongs to pictures, not to the solid: Gaussian, correlated over a few pixels,
  // and stronger or weaker by how light a pixel is. White noise filtered with a kernel, times a deviation.
  struct Noise {
    static constexpr int kReach = 8;
    // Deviations of sRGB-encoded values where their mean is (k + ½) / n: of this mean, and of each of two
    // orthonormal axes of chroma. Empty: no noise.
    std::vector<float> gray, chroma;
    // (2·kReach + 1)² values each, row by row, whose squares sum to 1. Empty with an empty deviation.
    std::vector<float> gray_kernel, chroma_kernel;
  };
  // The outside of a photographed stone, seen from above, without the light and shade of its form. Rows run
  // downwards. Beyond the stone's outline, and where something hides or shadows it, its texture continues.
  struct Skin {
    std::int32_t profile = 0;  // number in Labels, from 1
    Vec2 corner =
        Vec2::Zero();  // the upper left one, mm from the lower left corner of the photograph's section
    float size = 0;    // of the silhouette, √(4A/π), mm
    Vec3f color = Vec3f::Zero();                           // the stone's median, scene-linear
    int width = 0, height = 0;                             // pixels of the photograph
    Eigen::Vector2f center = Eigen::Vector2f::Zero();      // of the silhouette, pixels
    Eigen::Matrix2f spread = Eigen::Matrix2f::Identity();  // variance of its points, pixels²
    std::vector<Vec3f> shade;                              // skin_shade() of each pixel, row by row
  };
  // The logarithm of a color relative to another one, and the color that has it. Very dark colors count as
  // similar, because the camera's noise is all that tells them apart.
  static constexpr float kSkinDark = 0.01F;
  static Vec3f skin_shade(const Vec3f& color, const Vec3f& usual) {
    return ((color.array().max(0) + kSkinDark) / (usual.array().max(0) + kSkinDark)).log();
  }
  static Vec3f with_shade(const Vec3f& usual, const Vec3f& shade) {
    return ((usual.array().max(0) + kSkinDark) * shade.array().exp() - kSkinDark).max(0);
  }
  std::vector<Skin> skins;  // of a surface's stones; other views have none
  // How much of the skins' shade is relief, which light from another side would show otherwise, not stains.
  struct Relief {
    Eigen::Vector2f light = Eigen::Vector2f::UnitY();  // unit, right and upwards: toward it when photographed
    float strength = 0;  // power of relief relative to stains, of detail that runs across the light
  };
  Relief relief;
  // The soil between a surface's stones, continued below them, which repeats: skin_shade() relative to the
  // mean color of the soil, row by row from the top. Empty: none.
  struct Ground {
    int width = 0, height = 0;  // pixels of the photograph
    std::vector<Vec3f> shade;
  };
  Ground ground;
  // Luminance that k / (n − 1) of a surface's photograph does not exceed, for k = 0 … n − 1, scene-linear;
  // empty: unknown.
  std::vector<float> tones;
  Zones zones;
  Noise noise;
  double pixel_size = 1;      // mm, of the photograph; edge of the tiles' voxels
  int size = 0;               // edge of the tiles, voxels
  std::vector<Phase> phases;  // the binder, then groups of particles
  // Median color of profiles, scene-linear; their size √(4A/π), mm; and the deviation of their offsets
  // relative to their group's: that of the mean of the three channels (x), and that of the rest (y). A
  // particle has the contrast of the profile that is most like it in color and size.
  std::vector<Vec3f> profile_color;
  std::vector<float> profile_size;
  std::vector<std::int32_t> profile_group;        // index of its group in `phases`
  std::vector<Eigen::Vector2f> profile_contrast;  // of the grain
  std::vector<Eigen::Vector2f> profile_broad;     // of the broad part
  bool gray = false;                              // the photograph has no color, and neither have the offsets
  double softness = 0;                            // standard deviation of the blur of outlines, pixels
};

template <>
const ValueType& value_type<Detail>();

}  // namespace terrazzo
