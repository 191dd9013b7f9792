// Outlines of particles in files of other programs: GeoJSON, COCO, ImageJ.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

struct FileOutline {
  std::string name;  // as messages call it: "feature 3"
  int section = 0, cls = 0;
  double confidence = 1;
  // Pixels from the upper left corner of the first one, y down. The particle is what lies inside an odd
  // number of the loops: parts and holes.
  std::vector<Loop> loops;
};

using MapPlace = std::optional<Georeference>;  // of the picture that outlines belong to

struct OutlineFile {
  int width = 0, height = 0;  // of the picture, pixels; 0: the file does not say
  int sections = 1;
  double pixel_size = 0;                          // mm; 0: the file does not say
  std::optional<Georeference> georeference = {};  // of the picture
  bool on_map = false;                            // the outlines may be in coordinates of a map
  int epsg = 0;                                   // of that map; 0: the file does not say
  std::vector<FileOutline> outlines;
};

// Whether the file is JSON, an ImageJ ROI, or a zip archive, by its first bytes.
bool is_outline_file(const std::filesystem::path&);
// Whether it is an ImageJ ROI or a zip archive.
bool is_region_file(const std::filesystem::path&);

// Reads any of them. GeoJSON: Polygon and MultiPolygon features, coordinates in pixels, y down, as QuPath
// writes them. COCO: polygons and run lengths, one section per image. ImageJ: areas, one section per slice.
// GeoJSON's names of classes are numbered in alphabetical order; features without one come first. COCO's
// categories have the order of the file. Throws Error "unreadable-outlines", "unreadable-file",
// "bad-outline", "no-particles", "size-mismatch" for pictures of several sizes or scales, "too-large".
// GeoJSON with a member "crs" is on the map of the picture's `place`; Error "bad-georeference" if that is
// another map.
OutlineFile read_outline_file(const std::filesystem::path&, const Reading&, const Work& = {},
                              const MapPlace& = {});
// The same for the text of a JSON file.
OutlineFile read_outline_text(const std::string& text, const std::string& file, const Reading&,
                              const Work& = {}, const MapPlace& = {});

// From coordinates on the map.
void to_pixels(OutlineFile&, const Georeference&);

// Gives outlines the size of their picture, and with `all_sections` its sections. Throws Error
// "size-mismatch" if the file says another or has more sections, "bad-outline" like require_inside.
void take_picture(OutlineFile&, const Image&, bool all_sections, const std::string& file);

// Throws Error "bad-outline" if an outline lies outside of the picture by more than half a pixel, by which
// programs differ in where the first pixel begins; if its size is unknown, above or left of it, or beyond
// 1,000,000 pixels.
void require_inside(const OutlineFile&, const std::string& file);
// The same, and for the first outline that crosses itself or has no area.
void require_simple(const OutlineFile&, const std::string& file, const Work& = {});

// Number of the outline of each pixel from 1, section by section; 0 outside of all. Throws Error
// "bad-outline" if two share pixels, or one has none.
std::vector<std::int32_t> raster_of(const OutlineFile&, const std::string& file, const Work& = {});
// Throws Error "bad-outline" if two outlines share pixels, with the memory of one section.
void require_apart(const OutlineFile&, const std::string& file, const Work& = {});

// The edges of the pixels of each label above 0: loops of whole numbers, outer ones with positive area
// (numerically, as for y up), holes with negative. Loops touch at corners but do not cross.
std::map<std::int32_t, std::vector<Loop>> pixel_outlines(const std::int32_t* labels, int width, int height,
                                                         const Work& = {});

// --- the formats. `file` is for messages.
OutlineFile read_geojson(const std::string& text, const std::string& file);
OutlineFile read_coco(const std::string& text, const std::string& file, const Reading&, const Work& = {});
FileOutline read_roi(const std::string& bytes, const std::string& file);
OutlineFile read_roi_zip(const std::filesystem::path&, const Reading&);

Error bad_outline(const std::string& file, const std::string& what, const std::string& hint);

}  // namespace terrazzo
