// Checks of image files that OpenImageIO and its libraries omit. Each takes the file's whole content. It
// throws Error "unreadable-image" with the problem, or warns.
#pragma once

#include <string>
#include <string_view>

#include "nodes/common/io/reading.h"

namespace terrazzo {

// OpenImageIO's name of the format, detected from the first bytes; "" if the format is not supported. The raw
// files of most cameras are TIFF files.
std::string picture_format(std::string_view content);
// What a file of another format is, such as "a Photoshop picture", or "".
std::string other_format(std::string_view content);

// Upper bound of pixel bytes per byte of file; infinite if a few bytes can encode any number of equal pixels.
// `compression` is OpenImageIO's name.
double largest_ratio(const std::string& format, const std::string& compression);

// Decodes the file coarsely with libjpeg, whose warnings OpenImageIO drops. A truncated file is an error.
void check_jpeg(std::string_view content, const Reading&);
// Verifies the checksum of every chunk and the presence of the last chunk.
void check_png(std::string_view content, const Reading&);
// Checks that every strip and tile of every page is within the file.
void check_tiff(std::string_view content, const Reading&);
// Checks that the file can contain its block table, which OpenEXR allocates without a check.
void check_exr(std::string_view content, const Reading&);
// Checks that the file contains as many pixels as its header says and that all color indices are valid;
// OpenImageIO checks neither. Rejects run-length encoded files.
void check_bmp(std::string_view content, const Reading&);

// Checks that all blocks and frames are within the file, and that the frames fit the memory.
void check_gif(std::string_view content, const Reading&);

// The number of color components, without decoding; 0 if the header is damaged.
int jpeg_components(std::string_view content);
// The number of frames of an animated PNG file, else 1.
std::uint32_t png_frames(std::string_view content);
// The number of frames of a GIF file.
int gif_frames(std::string_view content);
// The number of parts of an OpenEXR file, and an attribute of the first one, "" if it has none.
int exr_parts(std::string_view content);
std::string_view exr_attribute(std::string_view content, std::string_view name);

// Rejects XMP metadata that is nested deeply enough to exhaust the stack, since OpenImageIO parses it
// recursively.
void check_notes(std::string_view content);

// Throws Error "unreadable-image".
[[noreturn]] void damaged_picture(const std::string& what);

}  // namespace terrazzo
