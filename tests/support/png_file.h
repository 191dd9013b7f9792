// Writes PNG files of any kind, with any chunks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace terrazzo::test {

std::string png_number(std::uint32_t);  // big-endian
std::string png_chunk(const std::string& name, const std::string& data);

struct PngFile {
  int width = 0, height = 0;
  int depth = 8;
  int kind = 0;             // 0 gray, 2 RGB, 3 palette, 4 gray with alpha, 6 RGB with alpha
  std::string rows = {};    // packed, without filter bytes
  std::string chunks = {};  // before the pixels: palette, transparency, color spaces
};

std::string png_file(const PngFile&);

}  // namespace terrazzo::test
