#include "nodes/common/io/pictures/picture_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "graph/diagnostic.h"

namespace terrazzo {
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
  if (c.starts_with("GIF87a"sv) || c.starts_with("GIF89a"sv)) return "gif";
  // Fujifilm, Panasonic, Olympus, Minolta, Canon's CR3, and Sigma
  if (c.starts_with("FUJIFILMCCD-RAW"sv) || c.starts_with("IIU\0"sv) || c.starts_with("IIRO"sv) ||
      c.starts_with("IIRS"sv) || c.starts_with("MMOR"sv) || c.starts_with("\0MRM"sv) ||
      c.substr(0, 12).substr(std::min<std::size_t>(c.size(), 4)) == "ftypcrx "sv || c.starts_with("FOVb"sv))
    return "raw";
  return "";
}

std::string other_format(std::string_view c) {
  using namespace std::string_view_literals;
  const std::string_view kind = c.size() > 12 ? c.substr(4, 8) : ""sv;
  if (kind.starts_with("ftyphe"sv) || kind == "ftypmif1"sv || kind == "ftypmsf1"sv) return "a HEIC picture";
  if (kind == "ftypavif"sv || kind == "ftypavis"sv) return "an AVIF picture";
  if (kind.starts_with("ftyp"sv)) return "a video";
  if (c.starts_with("RIFF"sv) && c.size() > 12 && c.substr(8, 4) == "WEBP"sv) return "a WebP picture";
  if (c.starts_with("8BPS"sv)) return "a Photoshop picture";
  if (c.starts_with("\0\0\0\x0cjP  "sv) || c.starts_with("\xff\x4f\xff\x51"sv)) return "a JPEG 2000 picture";
  if (c.starts_with("\0\0\0\x0cJXL "sv) || c.starts_with("\xff\x0a"sv)) return "a JPEG XL picture";
  if (c.starts_with("gimp xcf"sv)) return "a GIMP picture";
  if (c.starts_with("%PDF"sv)) return "a PDF document";
  if (c.starts_with("DDS "sv)) return "a DDS texture";
  if (c.starts_with("SDPX"sv) || c.starts_with("XPDS"sv)) return "a DPX picture";
  if (c.starts_with("P7\n"sv)) return "a PAM picture";
  if (c.starts_with("<svg"sv) || (c.starts_with("<?xml"sv) && c.substr(0, 1000).find("<svg"sv) != c.npos))
    return "an SVG drawing";
  return "";
}

void check_notes(std::string_view content) {
  constexpr std::string_view kBegin = "<rdf:Description";
  constexpr int kDeepest = 500;
  for (auto at = content.find(kBegin); at != std::string_view::npos; at = content.find(kBegin, at)) {
    // The parser also ends at a zero byte.
    int depth = 0;
    for (; at < content.size() && content[at] != '\0'; ++at) {
      if (content[at] != '<' || at + 1 == content.size()) continue;
      const char next = content[at + 1];
      depth += next == '/' ? -1 : next == '!' || next == '?' ? 0 : 1;
      if (depth > kDeepest) damaged_picture("its XMP metadata is nested too deeply");
    }
  }
}

double largest_ratio(const std::string& format, const std::string& compression) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  constexpr double kDeflate = 1032;  // zlib's limit
  if (format == "jpeg")
    return 2000;  // progressive: one bit per block of 64 or more samples, and subsampled colors
  if (format == "png") return 8 * kDeflate;  // 1-bit pixels become bytes
  if (format == "hdr") return 128;
  if (format == "bmp") return 32;  // 1-bit pixels become three bytes
  if (format == "pnm") return 8;
  if (format == "gif") return 4096;  // a code of 12 bits stands for up to 4,096 pixels
  if (compression == "none") return 8;
  if (compression == "zip" || compression == "zips") return 8 * kDeflate;
  if (compression == "lzw" || compression == "packbits" || compression == "rle" || compression == "jpeg")
    return 20000;
  return kAny;
}

}  // namespace terrazzo
