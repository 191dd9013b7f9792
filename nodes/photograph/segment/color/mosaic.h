// An image as a mosaic of uniform patches, the units of color clusters and particles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/photograph/segment/color/lab_image.h"

namespace terrazzo::segment {

// Oklab with doubled chroma axes. This weights hue against lightness about as the eye does for distant
// patches; Oklab itself is scaled for just noticeable differences.
Vec3f patch_color(const Vec3f& oklab);
Vec3f patch_color_of_linear(const Vec3f& linear);
Vec3f linear_of_patch_color(const Vec3f& patch);

// A section in patch colors.
LabImage patch_section(const Image&, int section, const Work&);

// Norm of the central differences, per pixel.
std::vector<float> gradient_of(const LabImage&);

struct Mosaic {
  int width = 0, height = 0;
  LabImage image;                     // patch colors of the pixels, not denoised
  LabImage smooth;                    // denoised
  bool gray = false;                  // the image has no color
  float noise = 0;                    // of lightness
  float spread = 0;                   // standard deviation of the pixels' patch colors
  float contrast = 0;                 // usual color difference over four pixels: noise and texture
  std::vector<std::int32_t> patches;  // of each pixel, from 1
  std::vector<Vec3f> colors;          // of patch k at k − 1
  std::vector<float> areas;           // pixels
  std::size_t index(int x, int y) const { return pixel_at(x, y, width); }
};

// Diffusion, watershed of the gradient, then Mumford–Shah merging of neighbors up to three times the usual
// contrast of noise and texture, since most borders of a watershed are within one material.
Mosaic make_mosaic(const Image&, int section, const Work&);

// Computes the patches of m.smooth, their colors and areas, and the usual contrast.
void make_patches(Mosaic& m, const Work&);

}  // namespace terrazzo::segment
