#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

std::uint32_t exr_number(std::string_view at) {
  std::uint32_t v = 0;
  for (int k = 3; k >= 0; --k) v = v << 8 | static_cast<unsigned char>(at[k]);
  return v;
}

// Attributes have a name, a type, a size and a value; an empty name ends them. Reads those of the header at
// `at`, and returns where it ends.
std::size_t read_exr_header(std::string_view content, std::size_t at,
                            const std::function<void(std::string_view, std::string_view)>& take) {
  const auto word = [&] {
    const auto end = content.find('\0', at);
    if (end == std::string_view::npos || end - at > 255) damaged_picture("its header has no end");
    const auto found = content.substr(at, end - at);
    at = end + 1;
    return found;
  };
  while (true) {
    const auto name = word();
    if (name.empty()) return at;
    word();
    if (at + 4 > content.size()) damaged_picture("its header has no end");
    const std::uint32_t size = exr_number(content.substr(at));
    at += 4;
    if (size > content.size() - at) damaged_picture("its header has no end");
    take(name, content.substr(at, size));
    at += size;
  }
}

constexpr std::size_t kFirstHeader = 8;

}  // namespace

int exr_parts(std::string_view content) {
  constexpr std::uint32_t kMultiPart = 0x1000;
  if (content.size() < kFirstHeader || !(exr_number(content.substr(4)) & kMultiPart)) return 1;
  int parts = 0;
  // An empty header ends the list.
  for (std::size_t at = kFirstHeader; at < content.size() && content[at] != '\0'; ++parts)
    at = read_exr_header(content, at, [](std::string_view, std::string_view) {});
  return std::max(parts, 1);
}

std::string_view exr_attribute(std::string_view content, std::string_view name) {
  std::string_view found;
  read_exr_header(content, kFirstHeader, [&](std::string_view n, std::string_view value) {
    if (n == name) found = value;
  });
  return found;
}

void check_exr(std::string_view content, const Reading&) {
  double height = 0;
  int lines = 1;  // rows per block
  bool tiled = false;
  // In a multi-part file, of the first part.
  const std::size_t end =
      read_exr_header(content, kFirstHeader, [&](std::string_view name, std::string_view value) {
        if (name == "dataWindow" && value.size() == 16) {
          const std::int32_t low = exr_number(value.substr(4));
          const std::int32_t high = exr_number(value.substr(12));
          height = double(high) - low + 1;
        } else if (name == "compression" && value.size() == 1) {
          constexpr int kOfKind[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
          if (const unsigned char kind = value[0]; kind < 10) lines = kOfKind[kind];
        } else if (name == "tiles") {
          tiled = true;
          if (value.size() >= 8) lines = std::min(exr_number(value.substr(4)), 1u << 20);
        }
      });
  if (tiled && lines < 1) damaged_picture("its tiles are empty");
  if (height < 1) damaged_picture("it has no rows");
  if (8 * std::floor(height / lines) > (content.size() - end))
    damaged_picture(
        fmt::format("its header says {:.0f} rows, but the file has only {} bytes", height, content.size()));
}

}  // namespace terrazzo
