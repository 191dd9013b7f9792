// Georeferences of picture files: GeoTIFF 1.1 tags, and world files beside pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "nodes/common/io/pictures/picture_content.h"
#include "nodes/common/io/pictures/pixel_scale.h"

namespace terrazzo {

// None if the page has no such tags. Throws Error "bad-georeference" for tags that are damaged or contradict
// each other, and for pixels that are not square.
std::optional<StatedPlace> place_in_tiff(const PictureContent&, const PicturePage&);

// The world file of this picture, if there is one: a.jgw, a.jpgw or a.wld of a.jpg.
std::vector<std::filesystem::path> world_files(const std::filesystem::path& picture);

// From the world file; its unit is taken for meters. None if there is none. Throws Error
// "bad-georeference".
std::optional<StatedPlace> place_beside(const std::filesystem::path& picture, const Reading&);

}  // namespace terrazzo
