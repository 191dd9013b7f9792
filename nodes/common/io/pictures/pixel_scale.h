// The size of a pixel as an image file's metadata state it.
#pragma once

#include <optional>
#include <string>

#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/data/georeference.h"

namespace terrazzo {

struct PixelScale {
  double size = 0;         // mm per pixel
  double uncertainty = 0;  // relative
  std::string source;      // where the size comes from, for a message: "its resolution, 1200 pixels per inch"
};

// Where the picture lies on a map, and what that says about its pixels.
struct StatedPlace {
  Georeference georeference;
  double unit = 0;     // mm per unit of the map; 0: it has no unit of length, such as degrees
  std::string source;  // for a message: "its GeoTIFF tags"
};

// What the metadata state about sizes.
struct StatedSizes {
  std::optional<PixelScale> pixel;
  std::optional<double> field_of_view;  // degrees across the picture's longer side, 1 to 170
  std::optional<StatedPlace> place;
  bool turned = false;  // the pixels are stored turned or mirrored, and `place` is that of the stored ones
};

// The length of a unit of microscopes and scanners, such as "µm", in mm; 0 if the name is unknown.
double mm_of_unit(const std::string& unit);

// From, in this order: the calibration that ImageJ stores in TIFF files; focal length, subject distance and
// the pitch of the sensor (EXIF 2.32), with the size of a pixel in the plane of the subject; and the
// resolution of a scan. The resolution of a camera's picture, and resolutions that programs write by habit
// (72, 96, 180, 240 and 300 per inch), say nothing. None if there is no such information or it is absurd.
std::optional<PixelScale> pixel_scale_of(const PictureDecoder&);

// Of a camera whose 35 mm equivalent focal length f the metadata state (EXIF 2.32): 2·atan(18 mm / f), since
// the longer side of such film is 36 mm. It does not hold for a picture that was cropped since.
std::optional<double> field_of_view_of(const PictureDecoder&);

}  // namespace terrazzo
