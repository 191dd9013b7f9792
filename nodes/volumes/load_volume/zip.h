// Stacks of pictures in zip archives.
#pragma once

#include "nodes/volumes/load_volume/slices.h"

namespace terrazzo::load_volume {

bool is_zip(const std::filesystem::path&);

// Reads the pictures whose names match the glob `entry`, in natural order, one in memory at a time. An empty
// `entry` stands for all pictures, which must be one volume: a picture, or pictures of a single page in a
// folder of which a number in the name differs in each. Throws Error "unreadable-volume" if the archive is
// damaged or encrypted or has no such pictures, "several-files" with the names of its volumes, and those of
// read_slices.
LoadedScan read_zip(const std::filesystem::path&, const std::string& entry, const SliceOptions& = {},
                    const Work& = {}, const Reading& = {});

}  // namespace terrazzo::load_volume
