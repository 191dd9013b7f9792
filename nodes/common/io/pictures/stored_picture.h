// The numbers of a picture file as they are stored, for masks and volumes: not scaled, not inverted, without
// colors of a palette and without conversion of color spaces.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/common/io/pictures/picture_content.h"

namespace terrazzo {

enum class ColorKind { Plain, Palette, Ink, Lab };  // Plain: gray, RGB, or numbers without a color

struct StoredSamples {
  int width = 0, height = 0;
  int count = 1;          // samples per pixel, with alpha
  int alpha = -1;         // −1 if there is none
  bool is_color = false;  // the first three samples are red, green and blue
  ColorKind kind = ColorKind::Plain;
  bool is_float = false;
  int bits = 8;                // per sample
  bool white_is_zero = false;  // the file says that 0 is shown as white
  bool is_lossy = false;       // the numbers went through JPEG or another lossy compression
  // The colors of a palette, 0 to 255, if the numbers are its indices, and the alpha of the first ones.
  std::vector<std::array<std::uint8_t, 3>> palette;
  std::vector<std::uint8_t> palette_alpha;
  std::optional<double> clear;  // a gray value that the file declares to be transparent
  std::vector<double> values;   // row by row, the top row first after the file's orientation is applied

  // Samples that are neither alpha nor, in a picture with colors, extra ones.
  int plain() const { return is_color ? 3 : count - (alpha >= 0 ? 1 : 0); }
  double at(std::size_t pixel, int sample) const {
    return values[pixel * static_cast<std::size_t>(count) + static_cast<std::size_t>(sample)];
  }
};

// Reads one page. `more` is the number of additional bytes per pixel that the caller will need. Throws Error
// "unreadable-image", "unsupported-image", "too-large", and "bad-values" for whole numbers above 2^53, which
// are not exact.
StoredSamples stored_samples(const PictureContent&, const PicturePage&, const Reading&, double more);

// All but the values and the palette, without decoding.
StoredSamples tiff_description(const PictureContent&, const PicturePage&);

// The readers of the formats.
StoredSamples stored_tiff(const PictureContent&, const PicturePage&, const Reading&, double more);
StoredSamples stored_png(const PictureContent&, const Reading&, double more);
StoredSamples stored_gif(const PictureContent&, const PicturePage&, const Reading&, double more);
StoredSamples stored_bmp(const PictureContent&, const Reading&, double more);  // with a palette
StoredSamples stored_pnm(const PictureContent&, const Reading&, double more);  // P1 to P6

// Sets the size, checks that the file can contain so many bytes at `ratio` to one, and allocates the values.
void allocate_samples(StoredSamples&, const PictureContent&, double width, double height, double ratio,
                      const Reading&, double more);

}  // namespace terrazzo
