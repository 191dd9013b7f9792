#include "nodes/common/io/pictures/picture_metadata.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/tiff_directory.h"

namespace terrazzo {
namespace {

constexpr Chromaticities kAdobeRgb = {{0.64, 0.33}, {0.21, 0.71}, {0.15, 0.06}, {0.3127, 0.3290}};
constexpr Chromaticities kRec2020 = {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}};
constexpr Chromaticities kP3 = {{0.68, 0.32}, {0.265, 0.69}, {0.15, 0.06}, {0.3127, 0.3290}};

std::uint32_t big_number(std::string_view at, std::size_t bytes) {
  std::uint32_t v = 0;
  for (std::size_t k = 0; k < bytes; ++k) v = v << 8 | static_cast<unsigned char>(at[k]);
  return v;
}

// The data of the EXIF segment of a JPEG file, or "".
std::string_view jpeg_exif(std::string_view content) {
  using namespace std::string_view_literals;
  constexpr auto kName = "Exif\0\0"sv;
  for (std::size_t at = 2; at + 4 <= content.size() && content[at] == '\xff';) {
    const unsigned char kind = content[at + 1];
    constexpr unsigned char kFill = 0xff, kScan = 0xda, kExif = 0xe1;
    if (kind == kFill) {
      ++at;
      continue;
    }
    if (kind == kScan) return {};
    const std::size_t length = big_number(content.substr(at + 2), 2);
    if (length < 2 || length > content.size() - at - 2) return {};
    const std::string_view data = content.substr(at + 4, length - 2);
    if (kind == kExif && data.starts_with(kName)) return data.substr(kName.size());
    at += 2 + length;
  }
  return {};
}

// The chunks before the pixels. check_png() has verified their lengths.
std::map<std::string, std::string_view> png_chunks(std::string_view content) {
  std::map<std::string, std::string_view> out;
  for (std::size_t at = 8; at + 12 <= content.size();) {
    const std::uint32_t length = big_number(content.substr(at), 4);
    const std::string name(content.substr(at + 4, 4));
    if (length > content.size() - at - 12 || name == "IEND") break;
    out.emplace(name, content.substr(at + 8, length));
    at += 12 + length;
  }
  return out;
}

void apply_exif(std::string_view block, PictureMetadata& out) try {
  if (block.size() < 8 || picture_format(block) != "tiff") return;
  const TiffReader in(block);
  const TiffDirectory first = in.directory(in.first());
  out.orientation = in.value(first, tiff::kOrientation, 1) & 15;
  const auto at = in.value(first, tiff::kExif, 0);
  if (at == 0) return;
  constexpr std::uint64_t kColorSpace = 0xa001, kInteroperability = 0xa005, adobe_rgb = 2;
  const TiffDirectory exif = in.directory(at);
  bool adobe = in.value(exif, kColorSpace, 1) == adobe_rgb;  // as some cameras write it
  if (const auto more = in.value(exif, kInteroperability, 0); more != 0)
    adobe = adobe || in.text(in.directory(more), 1) == "R03";
  if (adobe) out.colors = StatedColors{kAdobeRgb, Transfer::Power, 563.0 / 256, "its EXIF data (Adobe RGB)"};
} catch (const Error&) {
}

// Coding-independent code points, ITU-T H.273.
void apply_code_points(std::string_view data, PictureMetadata& out) {
  if (data.size() < 4) return;
  StatedColors colors;
  colors.source = "its PNG chunk cICP";
  const int primaries = data[0], transfer = data[1];
  bool known = data[2] == 0;
  if (primaries == 9)
    colors.chromaticities = kRec2020;
  else if (primaries == 12)
    colors.chromaticities = kP3;
  else
    known = known && primaries == 1;
  if (transfer == 1 || transfer == 6 || transfer == 14 || transfer == 15)
    colors.transfer = Transfer::Rec709;
  else if (transfer == 4 || transfer == 5 || transfer == 8) {
    colors.transfer = Transfer::Power;
    colors.exponent = transfer == 4 ? 2.2 : transfer == 5 ? 2.8 : 1;
  } else
    known = known && transfer == 13;
  if (!known) {
    out.unknown_encoding =
        fmt::format("its PNG chunk cICP states primaries {} and transfer {}", primaries, transfer);
    return;
  }
  out.overrides_profile = true;
  out.colors = colors;
}

// The same but for rounding.
bool is_near(const Chromaticities& a, const Chromaticities& b) {
  const auto near = [](const std::array<double, 2>& p, const std::array<double, 2>& q) {
    constexpr double kRounding = 5e-4;
    return std::abs(p[0] - q[0]) < kRounding && std::abs(p[1] - q[1]) < kRounding;
  };
  return near(a.red, b.red) && near(a.green, b.green) && near(a.blue, b.blue) && near(a.white, b.white);
}

void apply_png(std::string_view content, PictureMetadata& out) {
  const auto chunks = png_chunks(content);
  const auto chunk = [&](const char* name) {
    const auto found = chunks.find(name);
    return found == chunks.end() ? std::string_view() : found->second;
  };
  if (!chunk("eXIf").empty()) apply_exif(chunk("eXIf"), out);
  if (!chunk("cICP").empty()) return apply_code_points(chunk("cICP"), out);
  if (!chunk("sRGB").empty()) {
    out.colors.reset();
    return;
  }
  constexpr double kUnit = 100000;
  const std::string_view gamma = chunk("gAMA"), colors = chunk("cHRM");
  if (gamma.size() < 4 && colors.size() < 32) return;
  StatedColors stated;
  if (colors.size() >= 32) {
    const auto pair = [&](std::size_t i) {
      return std::array{big_number(colors.substr(8 * i), 4) / kUnit,
                        big_number(colors.substr(8 * i + 4), 4) / kUnit};
    };
    stated.chromaticities = {pair(1), pair(2), pair(3), pair(0)};
  }
  // With the primaries of sRGB, 1/2.2 stands for its curve: programs write it as the nearest power.
  const bool of_srgb = is_near(stated.chromaticities, Chromaticities());
  if (const std::uint32_t g = gamma.size() < 4 ? 0 : big_number(gamma, 4);
      g > 0 && (!of_srgb || g < 45000 || g > 46000)) {
    stated.transfer = Transfer::Power;
    stated.exponent = kUnit / g;
  }
  stated.source = colors.size() >= 32 ? "its PNG chunks gAMA and cHRM" : "its PNG chunk gAMA";
  out.colors = stated;
}

// OpenEXR's attribute chromaticities of the first part: red, green, blue and white, each x and y.
void apply_exr(std::string_view content, PictureMetadata& out) {
  const std::string_view value = exr_attribute(content, "chromaticities");
  if (value.size() < 32) return;
  const auto at = [&](std::size_t i) {
    std::uint32_t bits = 0;
    for (std::size_t k = 4; k-- > 0;) bits = bits << 8 | static_cast<unsigned char>(value[4 * i + k]);
    return static_cast<double>(std::bit_cast<float>(bits));
  };
  out.colors = StatedColors{{{at(0), at(1)}, {at(2), at(3)}, {at(4), at(5)}, {at(6), at(7)}},
                            Transfer::Power,
                            1,
                            "its chromaticities"};
}

}  // namespace

PictureMetadata metadata_of(const PictureContent& c, const PicturePage& page) {
  PictureMetadata out;
  if (c.format == "jpeg") apply_exif(jpeg_exif(c.bytes), out);
  if (c.format == "png") apply_png(c.bytes, out);
  if (c.format == "openexr") apply_exr(c.bytes, out);
  if (c.format == "tiff") {
    apply_exif(c.bytes, out);
    const TiffReader in(c.bytes);
    out.orientation = in.value(in.directory(page.directory), tiff::kOrientation, 1) & 15;
  }
  if (out.orientation < 1 || out.orientation > 8) out.orientation = 1;
  return out;
}

}  // namespace terrazzo
