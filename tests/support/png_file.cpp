#include "tests/support/png_file.h"

#include <zlib.h>

namespace terrazzo::test {

std::string png_number(std::uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
          static_cast<char>(v)};
}

std::string png_chunk(const std::string& name, const std::string& data) {
  const std::string body = name + data;
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return png_number(static_cast<std::uint32_t>(data.size())) + body +
         png_number(static_cast<std::uint32_t>(sum));
}

std::string png_file(const PngFile& p) {
  const std::size_t row = p.rows.size() / static_cast<std::size_t>(p.height);
  std::string raw;
  for (int y = 0; y < p.height; ++y) raw += '\0' + p.rows.substr(static_cast<std::size_t>(y) * row, row);
  std::string packed(compressBound(raw.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
           raw.size());
  packed.resize(size);
  const std::string header = png_number(static_cast<std::uint32_t>(p.width)) +
                             png_number(static_cast<std::uint32_t>(p.height)) + static_cast<char>(p.depth) +
                             static_cast<char>(p.kind) + std::string(3, '\0');
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + p.chunks + png_chunk("IDAT", packed) +
         png_chunk("IEND", "");
}

}  // namespace terrazzo::test
