// Numbers as files store them, in either byte order.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "nodes/volumes/load_volume/scan.h"

namespace terrazzo::load_volume {

struct NumberType {
  enum class Kind { Signed, Unsigned, Float } kind = Kind::Unsigned;
  std::size_t bytes = 1;  // 1, 2, 4, 8; floats 2, 4, 8
  bool big_endian = false;
};

// Appends the numbers of `bytes` to the scan, as whole numbers if the type is one, or if all doubles so far
// are whole. The caller has called require_voxels(). Throws Error "bad-values" for a whole number beyond 32
// bits.
void append_numbers(LoadedScan&, const NumberType&, std::string_view bytes, const std::string& file);
// The same for numbers that are written as text, separated by blanks or commas, `count` of them.
void append_text_numbers(LoadedScan&, const NumberType&, std::string_view text, std::size_t count,
                         const std::string& file);

// All of the text as one number, surrounded by blanks or not. Nothing if it is none. Independent of the
// locale.
std::optional<double> number_in(std::string_view text);
std::optional<std::int64_t> whole_number_in(std::string_view text);

// The voxels of a file of any format.
struct StoredArray {
  NumberType type;
  enum class Encoding { Raw, Deflated, Text } encoding = Encoding::Raw;  // Deflated: by zlib or gzip
  std::string_view data;                                                 // from the first voxel on
  std::size_t content = 0;  // bytes that the file takes in memory
};
// Fills the scan, whose size is set, x fastest. Throws Error "too-large", "unreadable-volume" if the data end
// early, "bad-values".
void take_voxels(LoadedScan&, const StoredArray&, const std::filesystem::path&, const Work&, const Reading&);

// The data file that a header names, in the header's folder or below. Throws Error "unreadable-volume" for
// other places: a file from a stranger must not open any file.
std::filesystem::path file_beside(const std::filesystem::path& header, const std::string& name);

}  // namespace terrazzo::load_volume
