// Outlines of profiles in pixels, and the files of other programs that hold them.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/io/outlines/outline_file.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"

namespace terrazzo::exporting {

// The edges of the pixels of each label. Throws Error "empty-labels".
OutlineFile outlines_of(const Labels&);
// The outer outlines of profiles, in the pixels of their picture. Throws Error "no-outlines" if a profile has
// none.
OutlineFile outlines_of(const Profiles&, int width, int height, double pixel_size);

// A loop with its holes: the outer loops of an outline, and the holes that the smallest of them contains.
std::vector<std::vector<Loop>> polygons_of(const std::vector<Loop>&);

// RFC 7946, coordinates in pixels, y down, or on the map of a georeferenced picture, with the properties that
// QuPath reads; `picture` holds the size of the picture.
std::string geojson_of(const OutlineFile&);
// COCO's format for object detection. Outlines with holes are written as run lengths.
std::string coco_of(const OutlineFile&);
// ImageJ's region. With `grouped`, its group is the class plus 1. Throws Error "format-does-not-fit" beyond
// ±32,767 pixels or 255 classes.
std::string roi_of(const FileOutline&, bool in_stack, bool grouped);
// A set of them for ImageJ's ROI Manager, one per outline. Throws Error "write-failed".
void write_roi_zip(const std::filesystem::path&, const OutlineFile&);

}  // namespace terrazzo::exporting
