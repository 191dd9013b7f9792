// Masks from files: instances or classes, identified by pixel value or by color.
#pragma once

#include <filesystem>
#include <vector>

#include "nodes/common/io/picture_pages.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/image.h"
#include "nodes/data/indices.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::load_labels {

enum class MaskKind { Instances, Classes };  // what each value is

// The pixels of one mask: 0 for background (0, black or transparent), otherwise the pixel's number or index
// of a palette, or for a color 0xRRGGBB + 1. Numbers are those of the file, never scaled.
struct RawMask {
  int width = 0, height = 0;
  std::vector<std::uint32_t> values;
  std::uint32_t at(int x, int y) const { return values[pixel_at(x, y, width)]; }
};

// Reads one page: integers of 1 to 64 bits, floats with whole numbers, indices of a palette, and 8-bit
// colors. Throws Error "unreadable-image", "too-large", "several-pages" or "several-channels" if the choice
// is open, "bad-labels" if a value is not a whole number from 0 to 4,294,967,294, "lossy-mask" for JPEG, and
// "blurred-mask" if most values occur only where others meet.
RawMask read_mask(const std::filesystem::path&, const PageOptions& = {}, const Reading& = {});

// Each value is one profile of its section, connected or not. Profiles are numbered by section, then by
// increasing value. Throws Error "size-mismatch", "no-particles".
Labels labels_from_instances(const std::vector<RawMask>&, double pixel_size);

// Each value is a class; its 8-connected components are the profiles. Classes are numbered by increasing
// value over all sections. Throws Error "size-mismatch", "no-particles", "too-many-classes" above 64 classes
// (such a mask contains instances, or was blurred), and "blurred-mask" if most classes have only scattered
// pixels.
Labels labels_from_classes(const std::vector<RawMask>&, double pixel_size);

// The outlines of files of other programs, each with one or several sections, as labels: the outlines in
// their order, of particles whose pixels have their centers inside. `picture`: null, or the picture that they
// belong to, which a file that does not know its own needs. `pixel_size`: 0 for that of the file, else 1.
// Throws Error "missing-input", "size-mismatch", and those of read_outline_file and raster_of.
Labels labels_from_outlines(const std::vector<std::filesystem::path>&, const Image* picture,
                            double pixel_size, const Reading& = {}, const Work& = {});

// Sets the class of each profile: the most frequent value at its pixels, without background, less 1. Throws
// Error "size-mismatch", and "bad-labels" if a profile lies on the background or a class is above 1,000,000.
void set_classes(Labels&, const std::vector<RawMask>&);

}  // namespace terrazzo::load_labels
