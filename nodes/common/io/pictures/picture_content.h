// The bytes of an untrusted picture file, after checks of its structure.
#pragma once

#include <filesystem>
#include <string>

#include "graph/diagnostic.h"
#include "nodes/common/io/picture_pages.h"
#include "nodes/common/io/reading.h"

namespace terrazzo {

struct PictureContent {
  std::filesystem::path path;
  std::string bytes;
  std::string format;  // of picture_format(), or "raw" for the sensor's data of a camera
  PicturePages pages;
};

// Reads a JPEG, PNG, TIFF, OpenEXR, Radiance HDR, BMP, PNM, GIF or raw file, detected by content, and checks
// its structure. A truncated file is an error; other defects become warnings. Throws Error
// "unreadable-image", "unsupported-image" or "too-large".
PictureContent checked_picture(const std::filesystem::path&, const Reading&);
// The same for a file whose content is `bytes`.
PictureContent checked_picture(const std::filesystem::path&, std::string bytes, const Reading&);

Error unreadable_picture(const std::filesystem::path&, const std::string& why);
// For pictures that are valid, but of a kind that Terrazzo does not read. `what` follows the file's name.
Error unsupported_picture(const std::filesystem::path&, const std::string& what, const std::string& hint);

}  // namespace terrazzo
