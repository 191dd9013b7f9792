#include "nodes/common/io/pictures/picture_content.h"

#include <fmt/format.h>

#include <map>

#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

using Check = void (*)(std::string_view, const Reading&);
const std::map<std::string, Check> checks = {{"jpeg", check_jpeg},   {"png", check_png}, {"tiff", check_tiff},
                                             {"openexr", check_exr}, {"bmp", check_bmp}, {"gif", check_gif}};

constexpr const char* kFormats =
    "supported formats are JPEG, PNG, TIFF, OpenEXR, HDR, BMP, PNM, GIF and the raw files of cameras";

void check_structure(const PictureContent& c, const Reading& reading) {
  check_notes(c.bytes);
  Reading named = reading;
  const std::string name = c.path.filename().string();
  named.warn = [&](const std::string& message) { reading.warn(name + ": " + message); };
  if (const auto check = checks.find(c.format); check != checks.end()) check->second(c.bytes, named);
}

// What OpenImageIO would read, but not as it is meant.
void refuse_kinds(const PictureContent& c) {
  if (c.format == "jpeg" && jpeg_components(c.bytes) == 4)
    throw unsupported_picture(c.path, "is a CMYK picture, whose colors are amounts of ink",
                              "convert it to RGB with its color profile, in the program that made it");
  if (c.format == "png" && png_frames(c.bytes) > 1)
    throw Error("several-pages",
                fmt::format("'{}' is an animated PNG of {} frames", c.path.string(), png_frames(c.bytes)),
                "save the frame to read as a PNG file of its own")
        .parameter("path");
}

}  // namespace

Error unreadable_picture(const std::filesystem::path& path, const std::string& why) {
  return Error("unreadable-image", "cannot read the image '" + path.string() + "': " + why,
               std::string("check that the file is complete; ") + kFormats)
      .parameter("path");
}

Error unsupported_picture(const std::filesystem::path& path, const std::string& what,
                          const std::string& hint) {
  return Error("unsupported-image", fmt::format("'{}' {}", path.string(), what), hint).parameter("path");
}

PictureContent checked_picture(const std::filesystem::path& path, const Reading& reading) {
  try {
    return checked_picture(path, read_whole(path, reading), reading);
  } catch (Error& e) {
    if (e.diagnostic().code == "unreadable-file") throw unreadable_picture(path, e.diagnostic().message);
    throw e.parameter("path");
  }
}

PictureContent checked_picture(const std::filesystem::path& path, std::string bytes, const Reading& reading) {
  PictureContent c;
  c.path = path;
  c.bytes = std::move(bytes);
  try {
    c.format = picture_format(c.bytes);
    if (c.format.empty()) {
      const std::string other = other_format(c.bytes);
      if (!other.empty())
        throw Error(
            "unreadable-image",
            fmt::format("cannot read the image '{}': it is {}, which is not supported", path.string(), other),
            "convert it to PNG, TIFF or JPEG")
            .parameter("path");
      throw unreadable_picture(path, "its format is not supported");
    }
    check_structure(c, reading);
    c.pages = pages_of(c.bytes, c.format, path.filename().string());
  } catch (Error& e) {
    if (e.diagnostic().code == "unreadable-image" && e.diagnostic().parameter.empty())
      throw unreadable_picture(path, e.diagnostic().message);
    throw e.parameter("path");
  }
  if (c.pages.raw) c.format = "raw";
  refuse_kinds(c);
  return c;
}

}  // namespace terrazzo
