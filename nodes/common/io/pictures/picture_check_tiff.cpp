#include <fmt/format.h>

#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/tiff_directory.h"

namespace terrazzo {
namespace {

void check_blocks(const TiffReader& in, const TiffDirectory& d, std::uint64_t offsets,
                  std::uint64_t lengths) {
  const auto o = d.entries.find(offsets), l = d.entries.find(lengths);
  for (const auto& found : {o, l})
    if (found != d.entries.end() && found->second.width == 0)
      damaged_picture(fmt::format("its entry {} has an invalid type", found->first));
  if (o == d.entries.end() || l == d.entries.end()) return;
  const std::uint64_t n = std::min(o->second.count, l->second.count);
  for (std::uint64_t i = 0; i < n; ++i) {
    const std::uint64_t at = in.value(o->second, i), length = in.value(l->second, i);
    if (at > in.size() || length > in.size() - at)
      damaged_picture(fmt::format("it is truncated: its block {} of {} ends at byte {} of {}", i, n,
                                  static_cast<double>(at) + length, in.size()));
  }
}

void check_directory(const TiffReader& in, const TiffDirectory& d) {
  check_blocks(in, d, tiff::kStripOffsets, tiff::kStripLengths);
  check_blocks(in, d, tiff::kTileOffsets, tiff::kTileLengths);
}

}  // namespace

void check_tiff(std::string_view content, const Reading&) {
  if (content.size() < 8) damaged_picture("it is truncated");
  const TiffReader in(content);
  std::set<std::uint64_t> seen;
  for (const auto& d : main_directories(in)) {
    check_directory(in, d);
    for (const auto& sub : sub_directories(in, d, seen)) check_directory(in, sub);
  }
}

}  // namespace terrazzo
