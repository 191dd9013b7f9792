// Layout of an OpenVDB file: the position of its grids and the memory they need.
#pragma once

#include <string>
#include <vector>

#include "nodes/common/io/vdb_header.h"

namespace terrazzo::load_volume {

struct VdbGrid {
  std::string name;         // as shown to the user
  std::string unique_name;  // with a numeric suffix if several grids share a name
  std::string type;         // "Tree_float_5_4_3"
  std::string parent;       // unique name of the grid whose tree this one shares, or ""
  bool half = false;        // values are stored as 16-bit floats
  bool known = false;       // the type is supported; the fields below are set only then
  VdbMetadataMap metadata;
  std::size_t transform_at = 0, tree_at = 0;
  std::uint32_t compression = 0;
  double memory = 0;  // bytes needed for its tree
};

// Walks the whole file and checks that every length in it (of metadata, masks, values and compressed blocks)
// stays within the file. Throws Error "unreadable-volume".
std::vector<VdbGrid> vdb_grids(std::string_view bytes, const VdbHeader&);

}  // namespace terrazzo::load_volume
