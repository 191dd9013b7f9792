// Volumes from gray images: one slice per file, or the pages of one file.
#pragma once

#include <functional>

#include "nodes/common/io/pictures/picture_content.h"
#include "nodes/volumes/load_volume/scan.h"

namespace terrazzo::load_volume {

struct SliceOptions {
  PageOptions choice;
  bool stored_order = false;  // all pages are slices, whatever the metadata say
};

// Reads gray images of equal size in the order of `paths`, or the slices of one file. Rows are stored from
// the bottom up; numbers are kept as stored, whole ones of up to 31 bits exactly. Throws Error
// "unreadable-image", "size-mismatch", "not-a-volume" (colors), "too-large", "several-pages" and
// "several-channels".
LoadedScan read_slices(const std::vector<std::filesystem::path>&, const SliceOptions& = {}, const Work& = {},
                       const Reading& = {});
// The same for `count` pictures, which picture(i) reads.
LoadedScan read_slices(std::size_t count, const std::function<PictureContent(std::size_t)>& picture,
                       const SliceOptions&, const Work&, const Reading&);

}  // namespace terrazzo::load_volume
