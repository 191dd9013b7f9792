// Pictures and label pictures as files, checked to be whole.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"

namespace terrazzo {

// write_image (nodes/common/image_file.h), then read back: on a full disk some formats' writers report
// success. Throws Error "write-failed" where the file is not whole, and what write_image throws.
void write_picture(const std::filesystem::path&, const Image&, int section,
                   const std::string& provenance = {});

// The ids of one section as exact integers, no colour space: .png 16 bit, .tif and .exr 32 bit, one channel.
// Throws Error "too-many-labels" (an id above 65535 in a .png), "write-failed".
void write_labels(const std::filesystem::path&, const Labels&, int section = 0,
                  const std::string& provenance = {});

// "masks.png" → "masks_007.png" for section 7 of a stack; with more than 1000 sections more digits.
std::string section_name(const std::string& path, int section, int sections);

}  // namespace terrazzo
