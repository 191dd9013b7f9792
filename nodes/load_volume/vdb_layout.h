// The grids of an OpenVDB file: where they lie, and what reading them takes.
#pragma once

#include <string>
#include <vector>

#include "nodes/common/vdb_header.h"

namespace terrazzo::load_volume {

struct VdbGrid {
  std::string name;         // as the user knows it
  std::string unique_name;  // with a number if the file has several of one name
  std::string type;         // "Tree_float_5_4_3"
  std::string parent;       // unique name of the grid whose tree this one shares, or ""
  bool half = false;        // numbers are stored in 16 bits
  bool known = false;       // of a type that a volume may hold; what follows is known of these alone
  VdbMetadataMap metadata;
  std::size_t transform_at = 0, tree_at = 0;
  std::uint32_t compression = 0;
  double memory = 0;  // bytes of its tree, once read
};

// Walks through the whole file, so that every length in it, of metadata, masks, values and compressed blocks,
// is known to lie within the file. Throws Error "unreadable-volume".
std::vector<VdbGrid> vdb_grids(std::string_view bytes, const VdbHeader&);

}  // namespace terrazzo::load_volume
