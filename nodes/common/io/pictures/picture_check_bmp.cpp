#include <fmt/format.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

std::uint32_t little(std::string_view content, std::size_t at, std::size_t bytes) {
  std::uint32_t v = 0;
  for (std::size_t k = bytes; k-- > 0;) v = v << 8 | static_cast<unsigned char>(content[at + k]);
  return v;
}

// Checks the color index of each pixel in a row.
void check_row(std::string_view row, std::uint32_t width, unsigned bits, std::uint32_t colors) {
  const unsigned per_byte = 8 / bits, mask = (1u << bits) - 1;
  for (std::uint32_t x = 0; x < width; ++x) {
    const unsigned char byte = row[x / per_byte];
    const unsigned color = byte >> (bits * (per_byte - 1 - x % per_byte)) & mask;
    if (color >= colors) damaged_picture(fmt::format("a pixel has color index {} of {}", color, colors));
  }
}

}  // namespace

void check_bmp(std::string_view content, const Reading&) {
  constexpr std::size_t kFileHeader = 14, kLeastHeader = 40;
  if (content.size() < kFileHeader + kLeastHeader) damaged_picture("it is truncated");
  const std::uint32_t pixels_at = little(content, 10, 4), header = little(content, 14, 4);
  const std::int32_t width = little(content, 18, 4);
  const double height = std::abs(double(static_cast<std::int32_t>(little(content, 22, 4))));
  const unsigned bits = little(content, 28, 2);
  const std::uint32_t compression = little(content, 30, 4), used = little(content, 46, 4);
  const auto refuse = [](const std::string& what) {
    throw Error("unreadable-image", what, "save it as PNG");
  };
  if (header < kLeastHeader || header > content.size() - kFileHeader)
    refuse("its BMP header is of an unsupported kind");
  constexpr std::uint32_t kPlain = 0, kMasks = 3;
  if (compression != kPlain && !(compression == kMasks && (bits == 16 || bits == 32)))
    refuse("it is a compressed BMP file, which is not supported");
  if (bits != 1 && bits != 4 && bits != 8 && bits != 16 && bits != 24 && bits != 32)
    damaged_picture(fmt::format("its pixels have {} bits", bits));
  if (width < 1 || height < 1) damaged_picture("it has no pixels");
  const double row = 4 * std::floor((double(width) * bits + 31) / 32);
  if (pixels_at > content.size() || row * height > (content.size() - pixels_at))
    damaged_picture(fmt::format("{} bytes cannot hold {} × {:.0f} pixels", content.size(), width, height));
  if (bits > 8) return;
  const std::uint32_t all = 1u << bits, colors = used == 0 ? all : used;
  if (colors > all || kFileHeader + header + 4.0 * colors > content.size())
    damaged_picture(fmt::format("its palette has {} colors", colors));
  if (colors == all) return;
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
    check_row(content.substr(pixels_at + y * static_cast<std::size_t>(row)), width, bits, colors);
}

}  // namespace terrazzo
