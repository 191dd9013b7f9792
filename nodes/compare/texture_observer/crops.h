// Where the crops of a picture lie, and their pixels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/indices.h"
#include "runtime/work.h"

namespace terrazzo::texture_observer {

constexpr int kLevels = 3;  // full, half and quarter resolution
constexpr int kStrips = 4;  // parts of a half that are left out in turn to choose the regularization
constexpr double kRoundingVariance = 2e-6;  // of Oklab components, by rounding to 8 bits; about

struct CropOptions {
  int crop = 64;    // edge, pixels after reduction; a multiple of 8, at least 32
  int scale = 1;    // every scale × scale pixels are averaged to one
  int crops = 500;  // number per picture after which no more cells are judged
  std::uint64_t seed = 1;
};

struct Patch {
  int width = 0, height = 0;
  std::vector<Vec3f> lab;  // Oklab, rows from the top
  const Vec3f& at(int x, int y) const { return lab[pixel_at(x, y, width)]; }
};

// A rectangle of whole crops, normally 2 × 2. Cells never overlap, and no crop extends beyond its cell.
struct CropCell {
  int section = 0, x = 0, y = 0;  // top left corner, pixels after reduction
  int columns = 1, rows = 1;      // in crops
  int strip = 0;     // 0 … kStrips − 1, from the top of the first section to the bottom of the last
  bool odd = false;  // the color of its square on a checkerboard of cells
  std::array<Patch, kLevels> levels;
};

struct Crop {
  int cell = 0, x = 0, y = 0;  // top left corner within the cell, pixels after reduction
  bool judged = false;         // judged crops do not overlap; the others lie between them
};

// The crops of one half of a picture, cells in random order, the two colors in turn.
struct CropSet {
  int crop = 64;
  std::vector<CropCell> cells;  // two or more, of both colors
  std::vector<Crop> crops;      // ordered by cell
};

// The left half (0) and the right half (1) of all sections; a middle column that is left over belongs to
// neither. Colors are those of an 8-bit sRGB display: an observer must not see the difference between a
// photograph's 256 values and a computed picture's many. Equal sizes and seeds give equal positions. Throws
// Error "empty-image"; "bad-pixels"; "too-small" if a half of the picture `name` has fewer than two crops.
std::array<CropSet, 2> halves_of(const Image&, const std::string& name, const CropOptions&, const Work&);

}  // namespace terrazzo::texture_observer
