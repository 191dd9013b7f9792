// How a dataset of an HDF5 file is stored.
#pragma once

#include <string>
#include <vector>

#include "nodes/common/io/hdf5/hdf5_input.h"

namespace terrazzo {

inline constexpr std::uint64_t kNowhere = ~std::uint64_t{0};  // the address of what is not stored

struct Hdf5Input::Chunk {
  std::vector<std::uint64_t> first;  // element along each axis
  std::uint64_t at = 0, stored = 0;  // bytes in the file
  std::uint64_t skipped = 0;         // filters that were not applied, one bit each
};

struct Hdf5Input::Layout {
  Hdf5Array array;
  enum class Kind { Missing, Together, Chunks } kind = Kind::Missing;
  std::uint64_t at = kNowhere, size = 0;  // data, or the index of the chunks
  std::vector<std::uint64_t> most;        // sizes up to which the array may grow
  // The numbers of version 4 of the layout message. Version 3 has a tree of version 1.
  enum class Index { Tree1 = 0, Single = 1, Implicit = 2, FixedArray = 3, ExtensibleArray = 4, Tree2 = 5 };
  Index index = Index::Tree1;
  std::vector<std::uint64_t> chunk;  // elements along each axis
  bool whole_at_border = false;      // no filters for chunks that reach beyond the array
  std::uint64_t single_stored = 0, single_skipped = 0;
  std::vector<unsigned> filters;  // in the order of writing

  std::uint64_t chunks_along(std::size_t axis) const {
    return (array.size[axis] + chunk[axis] - 1) / chunk[axis];
  }
  std::uint64_t chunk_bytes() const {
    std::uint64_t bytes = array.bytes;
    for (const std::uint64_t n : chunk) bytes *= n;
    return bytes;
  }
  bool keeps_whole(const Chunk& c) const {
    bool inside = true;
    for (std::size_t a = 0; a < chunk.size(); ++a) inside = inside && c.first[a] + chunk[a] <= array.size[a];
    return whole_at_border && !inside;
  }
};

}  // namespace terrazzo
