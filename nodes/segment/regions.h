// A picture as a mosaic of even patches: what colour clusters and particles are made of.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/segment/lab_image.h"

namespace terrazzo {

// Oklab with its chroma axes doubled: differences of hue count against differences of light about as the eye
// has them over patches that lie far apart (Oklab itself is scaled to just noticeable ones).
Vec3f patch_color(const Vec3f& oklab);
Vec3f patch_color_of_linear(const Vec3f& linear);
Vec3f linear_of_patch_color(const Vec3f& patch);

// Norm of the central differences, per pixel.
std::vector<float> gradient_of(const LabImage&);

struct Mosaic {
  int width = 0, height = 0;
  LabImage image;                     // patch colours of the pixels, not denoised
  LabImage smooth;                    // denoised
  bool grey = false;                  // no colour anywhere
  float noise = 0;                    // of lightness
  float spread = 0;                   // standard deviation of the patch colours of the pixels
  float contrast = 0;                 // usual colour difference over four pixels: noise and texture
  std::vector<std::int32_t> patches;  // of each pixel, from 1
  std::vector<Vec3f> colors;          // of patch k at k − 1
  std::vector<float> areas;           // pixels
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

// Diffusion, watershed of the gradient, then Mumford–Shah merging up to three times the usual contrast of
// neighbours, which is noise and texture: most borders of a watershed lie within one material.
Mosaic make_mosaic(const Image&, int section, const Work&);

// The patches of m.smooth, their colours and areas, and the usual contrast.
void make_patches(Mosaic& m, const Work&);

}  // namespace terrazzo
