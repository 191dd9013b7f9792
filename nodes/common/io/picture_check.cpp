#include "nodes/common/io/picture_check.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

std::uint32_t little32(std::string_view at) {
  std::uint32_t v = 0;
  for (int k = 3; k >= 0; --k) v = v << 8 | static_cast<unsigned char>(at[static_cast<std::size_t>(k)]);
  return v;
}

}  // namespace

void damaged_picture(const std::string& what) {
  throw Error("unreadable-image", what, "check that the file is complete");
}

std::string picture_format(std::string_view c) {
  using namespace std::string_view_literals;
  if (c.starts_with("\xff\xd8\xff"sv)) return "jpeg";
  if (c.starts_with("\x89PNG\r\n\x1a\n"sv)) return "png";
  if (c.starts_with("II*\0"sv) || c.starts_with("MM\0*"sv) || c.starts_with("II+\0"sv) ||
      c.starts_with("MM\0+"sv))
    return "tiff";
  if (c.starts_with("\x76\x2f\x31\x01"sv)) return "openexr";
  if (c.starts_with("#?"sv)) return "hdr";
  if (c.starts_with("BM"sv)) return "bmp";
  if (c.size() > 2 && c[0] == 'P' && ((c[1] >= '1' && c[1] <= '6') || c[1] == 'F' || c[1] == 'f') &&
      (std::isspace(static_cast<unsigned char>(c[2])) || c[2] == '#'))
    return "pnm";
  return "";
}

void check_notes(std::string_view content) {
  constexpr std::string_view begin = "<rdf:Description";
  constexpr int deepest = 500;
  for (auto at = content.find(begin); at != std::string_view::npos; at = content.find(begin, at)) {
    // The parser also ends at a zero byte.
    int depth = 0;
    for (; at < content.size() && content[at] != '\0'; ++at) {
      if (content[at] != '<' || at + 1 == content.size()) continue;
      const char next = content[at + 1];
      depth += next == '/' ? -1 : next == '!' || next == '?' ? 0 : 1;
      if (depth > deepest) damaged_picture("its XMP metadata is nested too deeply");
    }
  }
}

double largest_ratio(const std::string& format, const std::string& compression) {
  constexpr double any = std::numeric_limits<double>::infinity();
  constexpr double deflate = 1032;  // zlib's limit
  if (format == "jpeg")
    return 2000;  // progressive: one bit per block of 64 or more samples, and subsampled colors
  if (format == "png") return 8 * deflate;  // 1-bit pixels become bytes
  if (format == "hdr") return 128;
  if (format == "bmp") return 32;  // 1-bit pixels become three bytes
  if (format == "pnm") return 8;
  if (compression == "none") return 8;
  if (compression == "zip" || compression == "zips") return 8 * deflate;
  if (compression == "lzw" || compression == "packbits" || compression == "rle" || compression == "jpeg")
    return 20000;
  return any;
}

void check_exr(std::string_view content, const Reading&) {
  // Attributes have a name, a type, a size and a value; an empty name ends them. In a multi-part file, this
  // reads the first part.
  std::size_t at = 8;
  const auto word = [&] {
    const auto end = content.find('\0', at);
    if (end == std::string_view::npos || end - at > 255) damaged_picture("its header has no end");
    const auto found = content.substr(at, end - at);
    at = end + 1;
    return found;
  };
  double height = 0;
  int lines = 1;  // rows per block
  bool tiled = false;
  while (true) {
    const auto name = word();
    if (name.empty()) break;
    word();
    if (at + 4 > content.size()) damaged_picture("its header has no end");
    const std::uint32_t size = little32(content.substr(at));
    at += 4;
    if (size > content.size() - at) damaged_picture("its header has no end");
    const auto value = content.substr(at, size);
    at += size;
    if (name == "dataWindow" && size == 16) {
      const auto low = static_cast<std::int32_t>(little32(value.substr(4)));
      const auto high = static_cast<std::int32_t>(little32(value.substr(12)));
      height = double(high) - low + 1;
    } else if (name == "compression" && size == 1) {
      constexpr int of_kind[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
      if (static_cast<unsigned char>(value[0]) < 10) lines = of_kind[static_cast<unsigned char>(value[0])];
    } else if (name == "tiles") {
      tiled = true;
      if (size >= 8) lines = static_cast<int>(std::min(little32(value.substr(4)), 1u << 20));
    }
  }
  if (tiled && lines < 1) damaged_picture("its tiles are empty");
  if (height < 1) damaged_picture("it has no rows");
  if (8 * std::floor(height / lines) > static_cast<double>(content.size() - at))
    damaged_picture(
        fmt::format("its header says {:.0f} rows, but the file has only {} bytes", height, content.size()));
}

}  // namespace terrazzo
