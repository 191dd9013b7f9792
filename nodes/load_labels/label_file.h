// Masks from files: instances or classes, by pixel value or by colour.
#pragma once

#include <filesystem>
#include <vector>

#include "nodes/common/reading.h"
#include "nodes/data/labels.h"

namespace terrazzo {

// One mask's pixels: 0 where background (0, black or transparent), else a number for each distinct value, or
// each distinct colour as 0xRRGGBB + 1. Values are those of the file, never scaled.
struct RawMask {
  int width = 0, height = 0;
  std::vector<std::uint32_t> values;
};

// 8, 16 and 32 bit, integer or float with whole numbers; grey, or 8 bit colour. Throws Error
// "unreadable-image", "too-large", and "bad-labels" if a value is no whole number from 0.
RawMask read_mask(const std::filesystem::path&, const Reading& = {});

// Each value is one profile in its section, whether in one piece or several. Ids follow section, then rising
// value. Throws Error "unequal-sections", "no-particles".
Labels labels_from_instances(const std::vector<RawMask>&, double pixel_size);

// Each value is a class; its connected components (8 neighbours) are the profiles. Classes are numbered by
// rising value over all sections. Throws Error "too-many-classes" above 64: then the mask holds instances, or
// was blurred.
Labels labels_from_classes(const std::vector<RawMask>&, double pixel_size);

}  // namespace terrazzo
