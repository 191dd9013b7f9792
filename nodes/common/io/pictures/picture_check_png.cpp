#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>

#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

std::uint32_t big32(std::string_view at) {
  std::uint32_t v = 0;
  for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<unsigned char>(at[k]);
  return v;
}

// Decompresses a text chunk, up to the size that libpng would decompress.
std::string unpacked(std::string_view bytes) {
  constexpr std::size_t kMost = 8'000'000, kDeflate = 1032;
  std::string out(std::min(kMost, kDeflate * (bytes.size() + 1)), '\0');
  z_stream z = {};
  if (inflateInit(&z) != Z_OK) return {};
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = bytes.size();
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = out.size();
  inflate(&z, Z_FINISH);
  out.resize(z.total_out);
  inflateEnd(&z);
  return out;
}

// Data of a zTXt chunk: a key, one byte, and compressed text. Data of an iTXt chunk: a key, a flag, one byte,
// a language, a translated key, and text.
void check_packed_note(std::string_view name, std::string_view data) {
  constexpr std::string_view kKey = "XML:com.adobe.xmp";
  auto at = kKey.size();
  if (!data.starts_with(kKey) || at + 3 > data.size() || data[at] != '\0') return;
  if (name == "iTXt") {
    if (data[at + 1] == 0) return;  // not compressed: checked with the rest of the file
    at = data.find('\0', at + 3);
    if (at != std::string_view::npos) at = data.find('\0', at + 1);
    if (at == std::string_view::npos) return;
    check_notes(unpacked(data.substr(at + 1)));
  } else if (name == "zTXt") {
    check_notes(unpacked(data.substr(at + 2)));
  }
}

}  // namespace

std::uint32_t png_frames(std::string_view content) {
  constexpr std::size_t kAround = 12;
  for (std::size_t at = 8; at + kAround <= content.size();) {
    const std::uint32_t length = big32(content.substr(at));
    const std::string_view name = content.substr(at + 4, 4);
    if (name == "acTL" && length >= 4) return big32(content.substr(at + 8));
    if (name == "IDAT" || length > content.size() - at - kAround) break;
    at += kAround + length;
  }
  return 1;
}

void check_png(std::string_view content, const Reading& reading) {
  constexpr std::size_t kAround = 12;  // length, name and checksum
  std::size_t at = 8, damaged = 0;
  std::string first;
  while (true) {
    if (content.size() - at < kAround)
      damaged_picture(fmt::format("it is truncated at byte {}", content.size()));
    const std::uint32_t length = big32(content.substr(at));
    if (length > content.size() - at - kAround)
      damaged_picture(fmt::format("it is truncated: it ends at byte {}, within a chunk of {} bytes",
                                  content.size(), length));
    const std::string_view body = content.substr(at + 4, 4 + length);
    const std::string name = printable(body.substr(0, 4));
    const auto sum =
        crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(body.data()), body.size());
    check_packed_note(body.substr(0, 4), body.substr(4));
    const bool critical = (body[0] & 0x20) == 0;
    if (sum != big32(content.substr(at + 8 + length))) {
      if (critical) damaged_picture(fmt::format("its chunk {} at byte {} is damaged", name, at));
      if (damaged++ == 0) first = name;
    }
    if (body.substr(0, 4) == "IEND") break;
    at += kAround + length;
  }
  if (damaged > 0)
    reading.warn(fmt::format("{} of the PNG file's metadata chunks {} damaged; first: {}", damaged,
                             damaged == 1 ? "is" : "are", first));
}

}  // namespace terrazzo
