// The structure of a VTK XML file of image data, and the bytes of its arrays.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/common/io/reading.h"
#include "nodes/data/linear.h"

namespace terrazzo::load_volume {

struct VtiArrayText {
  std::string name, type, format;  // as in the file: "Int32"; "ascii", "binary" or "appended"
  int components = 1;              // 1 or 3
  std::string text;                // of ascii and binary data
  std::uint64_t offset = 0;        // of appended data
};

struct VtiLayout {
  Vec3i size = Vec3i::Zero(), start = Vec3i::Zero();   // voxels; first index of the extent
  Vec3 origin = Vec3::Zero(), spacing = Vec3::Ones();  // as in the file
  Vec3i period = Vec3i::Zero();                        // field data `period`, or 0
  bool wide = false;                                   // lengths have 64 bits instead of 32
  bool compressed = false;                             // by zlib
  bool big_endian = false;                             // numbers and lengths
  bool raw = false;                                    // appended data is raw, not base64
  std::size_t appended_at = 0;                         // offset of the appended data in the file, or 0
  std::vector<VtiArrayText> cells;

  std::size_t word() const { return wide ? 8 : 4; }  // bytes of a length
};

// Arrays of other numbers of components than 1 and 3, and point data, are left out with a warning. Throws
// Error "unreadable-volume", "not-a-volume", "too-large" (over 2^31 voxels).
VtiLayout vti_layout(const std::string& content, const Reading&);

// The `count` values of an array, each of `bytes` bytes. Throws Error "unreadable-volume" if there are more
// or fewer.
std::string vti_bytes(std::string_view content, const VtiLayout&, const VtiArrayText&, std::size_t bytes,
                      std::size_t count);

}  // namespace terrazzo::load_volume
