// What a picture file states about its orientation and about the color space of its samples, apart from ICC
// profiles.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "nodes/common/io/pictures/picture_content.h"

namespace terrazzo {

// CIE xy of the primaries and of white.
struct Chromaticities {
  std::array<double, 2> red = {0.64, 0.33}, green = {0.3, 0.6}, blue = {0.15, 0.06}, white = {0.3127, 0.3290};
};

enum class Transfer { Srgb, Rec709, Power };

struct StatedColors {
  Chromaticities chromaticities;
  Transfer transfer = Transfer::Srgb;
  double exponent = 1;  // of Power: light = sample ^ exponent
  std::string source;   // for messages: "its PNG chunk gAMA"
};

struct PictureMetadata {
  int orientation = 1;                 // EXIF, 1 to 8; 1 is upright
  std::optional<StatedColors> colors;  // none: nothing is stated, or sRGB
  // The file states an encoding that is not a color space of pictures, such as PQ; "" if it does not.
  std::string unknown_encoding;
  bool overrides_profile = false;  // `colors` are more specific than an ICC profile: PNG's cICP
};

// Damaged metadata count as absent, since the pixels do not depend on them.
PictureMetadata metadata_of(const PictureContent&, const PicturePage&);

}  // namespace terrazzo
