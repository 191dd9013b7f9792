// How much one picture looks like another: histograms and patches, in Oklab.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

// A part of a picture's first section.
struct TexturePart {
  const Image* image = nullptr;
  std::vector<std::uint8_t> mask;  // one entry a pixel of the section; empty: all of it
};

// Colours of any three channels, and which of them belong to the part; empty: all.
struct PatchPicture {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;
  std::vector<std::uint8_t> inside;
};

// Mean over channels and quantiles of |Q_a − Q_b|.
double histogram_distance(const TexturePart& a, const TexturePart& b);

// Sliced Wasserstein distance between the distributions of 7 × 7 patches that lie whole inside the parts, at
// up to three scales: √ of the mean over directions of ∫(Q_a − Q_b)². Negative where no patch fits into one
// of them. `draw` picks other patches, for what chance alone gives.
double patch_distance(const TexturePart& a, const TexturePart& b, std::uint64_t draw = 0, const Work& = {});

// The same in the channels that the pictures are given in, of all pictures of a and all of b.
double patch_distance(std::vector<PatchPicture> a, std::vector<PatchPicture> b, std::uint64_t draw = 0,
                      const Work& = {});

// How far patches of a are from their nearest in b, at the finest scale: the `share` quantile, rms a pixel
// and channel. Up to 1024 patches of a, 2048 of b. Negative where none fits.
double nearest_patch(const std::vector<PatchPicture>& a, const std::vector<PatchPicture>& b, double share,
                     const Work& = {});

// The largest patch_distance between the left and the right half and between the upper and the lower half.
double patch_distance_floor(const Image&, const Work& = {});

}  // namespace terrazzo
