// Header of an OpenVDB file, read with every length checked against the file. OpenVDB's own reader trusts
// these lengths and allocates accordingly.
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace terrazzo {

// Cursor over bytes. Each step throws Error "unreadable-volume" if it would leave them.
class ByteCursor {
 public:
  explicit ByteCursor(std::string_view all, std::size_t at = 0) : all_(all), at_(at) {}
  template <class T>
  T take() {
    T v;
    std::memcpy(&v, take(sizeof v).data(), sizeof v);
    return v;
  }
  std::string_view take(std::uint64_t bytes);
  std::string_view text() {
    return take(take<std::uint32_t>());
  }  // length-prefixed, as OpenVDB stores strings
  void seek(std::uint64_t at);
  std::size_t at() const { return at_; }

 private:
  std::string_view all_;
  std::size_t at_;
};

struct VdbMetadata {
  std::string_view type, bytes;
};
using VdbMetadataMap = std::map<std::string, VdbMetadata>;
VdbMetadataMap take_vdb_metadata(ByteCursor&);

struct VdbHeader {
  std::uint32_t format = 0;            // version of the format
  std::uint32_t major = 0, minor = 0;  // of the library that wrote the file
  bool has_offsets = false;            // whether each grid's descriptor has its offsets
  VdbMetadataMap metadata;
  std::uint32_t grids = 0;
  std::size_t end = 0;  // offset of the first grid's descriptor
};
// The results are views into `bytes`. Throws Error "unreadable-volume".
VdbHeader read_vdb_header(std::string_view bytes);

}  // namespace terrazzo
