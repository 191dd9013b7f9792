// Masks from files: instances or classes, identified by pixel value or by color.
#pragma once

#include <filesystem>
#include <vector>

#include "nodes/common/io/reading.h"
#include "nodes/data/labels.h"

namespace terrazzo::load_labels {

enum class MaskKind { Instances, Classes };  // what each value is

// The pixels of one mask: 0 for background (0, black or transparent), otherwise the pixel's value, or for a
// color 0xRRGGBB + 1. Values are those of the file, never scaled.
struct RawMask {
  int width = 0, height = 0;
  std::vector<std::uint32_t> values;
};

// Reads 8, 16 and 32 bit integers, floats with whole numbers, gray images, and 8-bit colors. Throws Error
// "unreadable-image", "too-large", and "bad-labels" if a value is not a whole number ≥ 0.
RawMask read_mask(const std::filesystem::path&, const Reading& = {});

// Each value is one profile of its section, connected or not. Profiles are numbered by section, then by
// increasing value. Throws Error "size-mismatch", "no-particles".
Labels labels_from_instances(const std::vector<RawMask>&, double pixel_size);

// Each value is a class; its 8-connected components are the profiles. Classes are numbered by increasing
// value over all sections. Throws Error "size-mismatch", "no-particles", and "too-many-classes" above 64
// classes: such a mask contains instances, or was blurred.
Labels labels_from_classes(const std::vector<RawMask>&, double pixel_size);

// Sets the class of each profile: the most frequent value at its pixels, without background, less 1. Throws
// Error "size-mismatch", and "bad-labels" if a profile lies on the background or a class is above 1,000,000.
void set_classes(Labels&, const std::vector<RawMask>&);

}  // namespace terrazzo::load_labels
