// Stored numbers of BMP files with a palette, and of PBM, PGM and PPM files.
#include <fmt/format.h>

#include <charconv>

#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/stored_picture.h"
#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

std::uint32_t bmp_number(std::string_view content, std::size_t at, std::size_t bytes) {
  std::uint32_t v = 0;
  for (std::size_t k = bytes; k-- > 0;) v = v << 8 | static_cast<unsigned char>(content[at + k]);
  return v;
}

// The words and numbers of a PNM file; comments reach from # to the end of the line.
class PnmReader {
 public:
  explicit PnmReader(const PictureContent& c) : path_(c.path), text_(c.bytes) {}

  void skip(std::size_t bytes) { at_ += bytes; }
  long number() {
    skip_blanks();
    long v = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), v);
    if (error != std::errc() || v < 0)
      throw unreadable_picture(path_, fmt::format("a number is expected at byte {}", at_));
    at_ = end - text_.data();
    return v;
  }
  // A digit of P1, where blanks may be missing.
  int digit() {
    skip_blanks();
    if (at_ >= text_.size() || (text_[at_] != '0' && text_[at_] != '1'))
      throw unreadable_picture(path_, fmt::format("a 0 or 1 is expected at byte {}", at_));
    return text_[at_++] - '0';
  }
  std::string_view rest(double bytes) const {
    const std::size_t left = text_.size() - std::min(at_, text_.size());
    if (bytes > left)
      throw unreadable_picture(path_,
                               fmt::format("it is truncated: {} of {:.0f} bytes of pixels", left, bytes));
    return text_.substr(text_.size() - left);
  }

 private:
  void skip_blanks() {
    bool comment = false;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '#') comment = true;
      if (c == '\n' || c == '\r') comment = false;
      if (!comment && c != ' ' && c != '\t' && c != '\n' && c != '\r' && c != '\v' && c != '\f') return;
    }
  }

  const std::filesystem::path& path_;
  std::string_view text_;
  std::size_t at_ = 0;
};

void read_pnm_text(PnmReader& in, bool bitmap, long top, const PictureContent& c, StoredSamples& out) {
  for (double& v : out.values) {
    const long n = bitmap ? in.digit() : in.number();
    if (n > top) throw unreadable_picture(c.path, fmt::format("a pixel has the value {} of {}", n, top));
    v = n;
  }
}

void read_pnm_bytes(const PnmReader& in, bool bitmap, long top, StoredSamples& out) {
  const std::size_t wide = top > 255 ? 2 : 1;
  const std::size_t row = bitmap ? (static_cast<std::size_t>(out.width) + 7) / 8 : 0;
  const std::string_view bytes =
      in.rest(bitmap ? double(row) * out.height : double(wide) * double(out.values.size()));
  const auto byte = [&](std::size_t at) {
    return static_cast<unsigned>(static_cast<unsigned char>(bytes[at]));
  };
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    const std::size_t x = i % out.width, y = i / out.width;
    out.values[i] = bitmap      ? byte(y * row + x / 8) >> (7 - x % 8) & 1
                    : wide == 2 ? byte(2 * i) << 8 | byte(2 * i + 1)
                                : byte(i);
  }
}

}  // namespace

StoredSamples stored_bmp(const PictureContent& c, const Reading& reading, double more) {
  constexpr std::size_t kFileHeader = 14;
  const std::string_view content = c.bytes;
  const std::size_t pixels_at = bmp_number(content, 10, 4), header = bmp_number(content, 14, 4);
  const std::int32_t width = bmp_number(content, 18, 4);
  const std::int32_t height = bmp_number(content, 22, 4);
  const std::size_t bits = bmp_number(content, 28, 2), used = bmp_number(content, 46, 4);
  StoredSamples out;
  out.bits = bits;
  allocate_samples(out, c, width, std::abs(double(height)), 8, reading, more);
  const std::size_t colors = used == 0 ? std::size_t{1} << bits : used;
  for (std::size_t i = 0; i < colors && kFileHeader + header + 4 * i + 4 <= content.size(); ++i) {
    const auto color = [&](std::size_t k) {
      return static_cast<std::uint8_t>(content[kFileHeader + header + 4 * i + k]);
    };
    out.palette.push_back({color(2), color(1), color(0)});
  }
  const std::size_t row = (width * bits + 31) / 32 * 4, mask = (1u << bits) - 1;
  for (int y = 0; y < out.height; ++y) {
    const std::size_t line = height > 0 ? out.height - 1 - y : y;  // the last one comes first
    for (int x = 0; x < out.width; ++x) {
      const std::size_t bit = x * bits;
      const unsigned char byte = content[pixels_at + line * row + bit / 8];
      out.values[pixel_at(x, y, out.width)] = byte >> (8 - bits - bit % 8) & mask;
    }
  }
  return out;
}

StoredSamples stored_pnm(const PictureContent& c, const Reading& reading, double more) {
  PnmReader in(c);
  const int kind = c.bytes[1] - '0';
  const bool bitmap = kind == 1 || kind == 4, text = kind <= 3;
  in.skip(2);
  const double width = in.number(), height = in.number();
  const long top = bitmap ? 1 : in.number();
  if (top < 1 || top > 65535) throw unreadable_picture(c.path, fmt::format("its largest value is {}", top));
  in.skip(1);
  StoredSamples out;
  out.count = kind == 3 || kind == 6 ? 3 : 1;
  out.is_color = out.count == 3;
  out.bits = bitmap ? 1 : top > 255 ? 16 : 8;
  out.white_is_zero = bitmap;
  allocate_samples(out, c, width, height, 8, reading, more);
  if (text)
    read_pnm_text(in, bitmap, top, c, out);
  else
    read_pnm_bytes(in, bitmap, top, out);
  return out;
}

}  // namespace terrazzo
