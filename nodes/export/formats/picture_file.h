// Writes images and labels to files and checks that the files are complete.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"

namespace terrazzo::exporting {

// Calls write_image (nodes/common/io/image_file.h) and reads the file back, since the writers of some formats
// report success on a full disk. Throws Error "write-failed" if the file is incomplete, and the errors of
// write_image.
void write_picture(const std::filesystem::path&, const Image&, int section,
                   const std::string& provenance = {});

// The first section as a PNG file of 8 bits per channel, sRGB-encoded. Throws Error "empty-image",
// "write-failed".
std::string png_of(const Image&);

// Encodes samples as the encoding says, writes them and reads the file back. Throws Error "write-failed".
void write_samples(const std::filesystem::path&, const PictureEncoding&, const void* samples);
// The same as the bytes of a PNG file.
std::string encoded_png(const PictureEncoding&, const void* samples);

// Writes the ids of one section as exact integers in one channel, without color space: .png 16 bit, .tif and
// .exr 32 bit. Throws Error "too-many-labels" (an id above 65535 in a .png), "empty-labels", "bad-labels" (a
// negative id), "write-failed".
void write_labels(const std::filesystem::path&, const Labels&, int section = 0,
                  const std::string& provenance = {});

// "masks.png" → "masks_007.png" for section 7 of a stack. More than 1000 sections use more digits.
std::string section_name(const std::string& path, int section, int sections);

}  // namespace terrazzo::exporting
