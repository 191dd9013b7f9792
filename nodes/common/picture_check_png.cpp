#include <fmt/format.h>
#include <zlib.h>

#include "nodes/common/picture_check.h"

namespace terrazzo {
namespace {

std::uint32_t big32(std::string_view at) {
  std::uint32_t v = 0;
  for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<unsigned char>(at[k]);
  return v;
}

}  // namespace

void check_png(std::string_view content, const Reading& reading) {
  constexpr std::size_t around = 12;  // length, name and checksum
  std::size_t at = 8, damaged = 0;
  std::string first;
  while (true) {
    if (content.size() - at < around) damaged_picture(fmt::format("it was cut short at byte {}", content.size()));
    const std::uint32_t length = big32(content.substr(at));
    if (length > content.size() - at - around)
      damaged_picture(fmt::format("it was cut short: it ends at byte {} within a chunk of {}", content.size(), length));
    const std::string_view body = content.substr(at + 4, 4 + length);
    const std::string name = printable(body.substr(0, 4));
    const auto sum = crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(body.data()), body.size());
    const bool critical = (body[0] & 0x20) == 0;
    if (sum != big32(content.substr(at + 8 + length))) {
      if (critical) damaged_picture(fmt::format("its chunk {} at byte {} is damaged", name, at));
      if (damaged++ == 0) first = name;
    }
    if (body.substr(0, 4) == "IEND") break;
    at += around + length;
  }
  if (damaged > 0)
    reading.warn(fmt::format("{} of the PNG file's notes {} damaged; first: {}", damaged, damaged == 1 ? "is" : "are",
                             first));
}

}  // namespace terrazzo
