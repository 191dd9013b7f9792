// Paints one picture of a bed.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "nodes/bodies/carving/particle_colors.h"
#include "nodes/bodies/view/bed.h"
#include "nodes/bodies/view/shader.h"
#include "nodes/bodies/view/surface_view.h"

namespace terrazzo::view {

// All arrays are ordered row by row from the top.
class Painter {
 public:
  // `albedo`: the share of light that stones reflect, on average. `picture`: its number,
  // from 0, which decides how the rays of each pixel are turned. Everything must outlive the painter.
  Painter(const Bed&, const Shader&, const carving::ParticleColors&, const SurfaceOptions&, float albedo,
          int picture);

  // Writes the pixels.
  void paint(Vec3f* pixels, const Work&);
  // The stone at each pixel's center, −1 in soil and in the shadows between loose stones.
  const std::vector<std::int32_t>& stones() const { return stone_; }

 private:
  void each_row(const Work&, const std::function<void(int row)>&) const;
  std::size_t at(int x, int row) const { return pixel_at(x, row, options_.pixels_x); }
  float across(float x) const { return static_cast<float>(x * options_.width / options_.pixels_x); }
  float upwards(float row) const {
    return static_cast<float>((options_.pixels_y - row) * options_.height / options_.pixels_y);
  }
  // The stone above the soil at a place in pixels from the upper left corner, or the soil.
  BedPoint seen(float x, float row) const;

  std::vector<float> heights_of_stones(const Work&) const;
  // The height below which lies the part of the picture that stones don't cover, mm.
  float ground_level(std::vector<float> heights) const;
  void hide_ground();
  void paint_flat(Vec3f* pixels, const Work&);
  void paint_lit(Vec3f* pixels, const Work&);
  BedPoint color_pixel(int x, int row);
  void light_pixel(int x, int row);
  void raise_soil(const Work&);
  float soil_at(float x, float row) const;
  std::vector<float> smooth(const std::vector<float>&, const Work&) const;
  float mean_near(const std::vector<float>&, int x, int row) const;
  Vec3f color_near(int x, int row, int stone) const;
  Vec3f antialiased(int x, int row) const;

  const Bed& bed_;
  const Shader& shader_;
  const carving::ParticleColors& colors_;
  const SurfaceOptions& options_;
  float albedo_;
  std::uint64_t first_;              // number of the first pixel, of all pictures
  float soil_ = 0;                   // mean height, mm
  std::vector<float> relief_;        // of the soil at each pixel's center, mm; empty: level
  float ground_ = 0;                 // height of the shadows between loose stones, mm
  std::vector<std::int32_t> stone_;  // at the center of each pixel
  std::vector<float> height_;        // there, mm
  std::vector<Vec3f> color_;         // there, without light until it is known
  std::vector<float> sun_, sky_;     // light there
};

}  // namespace terrazzo::view
