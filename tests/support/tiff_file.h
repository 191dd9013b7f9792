// Writes TIFF files as other programs do: any kind of sample, pages, thumbnails and descriptions.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace terrazzo::test {

struct TiffPage {
  int width = 0, height = 0;
  int bits = 8, samples = 1;
  int format = 1;           // 1 unsigned, 2 signed, 3 floating-point
  int photometric = 1;      // 0 WhiteIsZero, 1 BlackIsZero, 2 RGB, 3 palette
  std::string pixels = {};  // in the file's byte order
  std::string description = {};
  // More tags with whole numbers, as SHORT, or as LONG if one is above 65535.
  std::vector<std::pair<int, std::vector<std::uint32_t>>> tags = {};
  std::vector<TiffPage> sub_pages = {};  // SubIFDs
};

struct TiffKind {
  bool big_endian = false;
  bool wide = false;  // BigTIFF
};

std::string tiff_file(const std::vector<TiffPage>&, const TiffKind& = {});

// The bytes of numbers in the byte order of the file.
template <class T>
std::string number_bytes(const std::vector<T>& values, bool big_endian = false) {
  std::string out;
  for (const T& v : values) {
    const std::string little(reinterpret_cast<const char*>(&v), sizeof v);
    out += big_endian ? std::string(little.rbegin(), little.rend()) : little;
  }
  return out;
}

}  // namespace terrazzo::test
