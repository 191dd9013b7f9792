// Checks of picture files that OpenImageIO and the libraries behind it leave out. Each gets a file's whole
// content and throws Error "unreadable-image" with what is wrong, or warns.
#pragma once

#include <string>
#include <string_view>

#include "nodes/common/reading.h"

namespace terrazzo {

// OpenImageIO's name of the format, told by the first bytes; "" if it is none that is read.
std::string picture_format(std::string_view content);

// The most bytes of pixels that one byte of such a file can stand for; infinite where a few bytes may stand
// for any number of equal pixels. `compression`: as OpenImageIO calls it.
double largest_ratio(const std::string& format, const std::string& compression);

// Decodes the file coarsely with libjpeg, whose warnings OpenImageIO swallows. A file that ends early is an
// error.
void check_jpeg(std::string_view content, const Reading&);
// Compares the checksum of every chunk, and looks for the last.
void check_png(std::string_view content, const Reading&);
// Whether every strip and tile of every page lies within the file.
void check_tiff(std::string_view content, const Reading&);
// Whether the file holds the table of its blocks, which OpenEXR allocates before it looks.
void check_exr(std::string_view content, const Reading&);
// Whether the file holds as many pixels as it says, and only colors that it lists; OpenImageIO looks neither
// up. Refuses run-length coded files.
void check_bmp(std::string_view content, const Reading&);

// OpenImageIO reads XMP notes by recursion: refuses notes that are nested deeply enough to exhaust the stack.
void check_notes(std::string_view content);

// Throws Error "unreadable-image".
[[noreturn]] void damaged_picture(const std::string& what);

}  // namespace terrazzo
