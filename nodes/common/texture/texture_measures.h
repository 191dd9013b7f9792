// Distances of textures in Oklab: by histograms and by patches.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

// A part of an image's first section.
struct TexturePart {
  const Image* image = nullptr;
  std::vector<std::uint8_t> mask;  // one entry per pixel of the section; empty: the whole section
};

// Pixels with any three channels, and whether each belongs to the part; empty: all do.
struct PatchPicture {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;
  std::vector<std::uint8_t> inside;
};

// Mean over channels and quantiles of |Q_a − Q_b|.
double histogram_distance(const TexturePart& a, const TexturePart& b);

// Sliced Wasserstein distance between the distributions of 7 × 7 patches completely inside the parts, at up
// to three scales: √ of the mean over directions of ∫(Q_a − Q_b)². Negative if no patch fits into one of the
// parts. `draw` selects a different random sample of patches, to measure the effect of sampling.
double patch_distance(const TexturePart& a, const TexturePart& b, std::uint64_t draw = 0, const Work& = {});

// The same for all images of a and all of b, in the images' own channels.
double patch_distance(std::vector<PatchPicture> a, std::vector<PatchPicture> b, std::uint64_t draw = 0,
                      const Work& = {});

// Distance of patches of a to their nearest patches of b at the finest scale: the `share` quantile, as rms
// per pixel and channel. Uses up to 1024 patches of a and 2048 of b. Negative if no patch fits.
double nearest_patch(const std::vector<PatchPicture>& a, const std::vector<PatchPicture>& b, double share,
                     const Work& = {});

// The larger of the patch distances between the left and right halves and between the upper and lower halves.
double patch_distance_floor(const Image&, const Work& = {});

}  // namespace terrazzo
