#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdarg>
#include <cstring>
#include <memory>

#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/stored_picture.h"
#include "nodes/common/io/pictures/tiff_directory.h"
#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

constexpr double kExact = 9007199254740992.0;  // 2^53

// libtiff reads from memory, and its messages are kept.
struct TiffSource {
  std::string_view content;
  std::uint64_t at = 0;
  std::string error, warning;
};

TiffSource& tiff_source(thandle_t handle) { return *static_cast<TiffSource*>(handle); }

tmsize_t tiff_read(thandle_t handle, void* to, tmsize_t size) {
  TiffSource& s = tiff_source(handle);
  const std::uint64_t left = s.content.size() - std::min<std::uint64_t>(s.at, s.content.size());
  const std::uint64_t n = std::min<std::uint64_t>(left, std::max<tmsize_t>(0, size));
  std::memcpy(to, s.content.data() + s.content.size() - left, n);
  s.at += n;
  return n;
}

tmsize_t tiff_write(thandle_t, void*, tmsize_t) { return 0; }

toff_t tiff_seek(thandle_t handle, toff_t offset, int whence) {
  TiffSource& s = tiff_source(handle);
  s.at = whence == SEEK_SET ? offset : whence == SEEK_CUR ? s.at + offset : s.content.size() + offset;
  return s.at;
}

int tiff_close(thandle_t) { return 0; }
toff_t tiff_size(thandle_t handle) { return tiff_source(handle).content.size(); }

std::string tiff_message(const char* format, std::va_list arguments) {
  char text[500];
  std::vsnprintf(text, sizeof text, format, arguments);
  return printable(text);
}

int tiff_error(TIFF*, void* data, const char*, const char* format, std::va_list arguments) {
  if (auto& s = *static_cast<TiffSource*>(data); s.error.empty()) s.error = tiff_message(format, arguments);
  return 1;
}

int tiff_warning(TIFF*, void* data, const char*, const char* format, std::va_list arguments) {
  if (auto& s = *static_cast<TiffSource*>(data); s.warning.empty())
    s.warning = tiff_message(format, arguments);
  return 1;
}

using OpenTiff = std::unique_ptr<TIFF, void (*)(TIFF*)>;

OpenTiff open_tiff(TiffSource& source) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, tiff_error, &source);
  TIFFOpenOptionsSetWarningHandlerExtR(options, tiff_warning, &source);
  TIFF* open = TIFFClientOpenExt("picture", "rm", &source, tiff_read, tiff_write, tiff_seek, tiff_close,
                                 tiff_size, nullptr, nullptr, options);
  TIFFOpenOptionsFree(options);
  return {open, TIFFClose};
}

// How a page stores its samples.
struct TiffLayout {
  int width = 0, height = 0, samples = 1, bits = 1, format = SAMPLEFORMAT_UINT;
  int photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
  bool separate = false;
  std::vector<int> extra;  // kinds of the samples beyond the color

  // Samples in one row of a strip or tile.
  int together() const { return separate ? 1 : samples; }
};

TiffLayout tiff_layout(const TiffReader& in, const TiffDirectory& d) {
  const auto whole = [&](std::uint64_t tag, std::uint64_t otherwise) {
    return static_cast<int>(std::min<std::uint64_t>(in.value(d, tag, otherwise), 1u << 30));
  };
  TiffLayout l;
  l.width = whole(tiff::kWidth, 0);
  l.height = whole(tiff::kHeight, 0);
  l.samples = whole(tiff::kSamples, 1);
  l.bits = whole(tiff::kBits, 1);
  l.format = whole(tiff::kSampleFormat, SAMPLEFORMAT_UINT);
  if (l.format == SAMPLEFORMAT_VOID) l.format = SAMPLEFORMAT_UINT;
  l.photometric = whole(tiff::kPhotometric, PHOTOMETRIC_MINISBLACK);
  l.compression = whole(tiff::kCompression, COMPRESSION_NONE);
  l.separate = whole(tiff::kPlanar, PLANARCONFIG_CONTIG) == PLANARCONFIG_SEPARATE;
  if (const auto extra = d.entries.find(tiff::kExtraSamples);
      extra != d.entries.end() && extra->second.width > 0)
    for (std::uint64_t i = 0; i < std::min<std::uint64_t>(extra->second.count, 1000); ++i)
      l.extra.push_back(in.value(extra->second, i));
  return l;
}

// OpenImageIO's name, for the largest ratio.
std::string tiff_compression(int compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return "none";
    case COMPRESSION_LZW:
      return "lzw";
    case COMPRESSION_JPEG:
      return "jpeg";
    case COMPRESSION_ADOBE_DEFLATE:
    case COMPRESSION_DEFLATE:
      return "zip";
    case COMPRESSION_PACKBITS:
      return "packbits";
    default:
      return "";
  }
}

bool is_lossy_compression(int compression) {
  constexpr int kJpeg2000 = 34712, kWebp = 50001, kJpegXl = 50002;
  return compression == COMPRESSION_OJPEG || compression == COMPRESSION_JPEG || compression == kJpeg2000 ||
         compression == kWebp || compression == kJpegXl || compression == COMPRESSION_LERC;
}

void require_supported(const TiffLayout& l, const std::filesystem::path& path) {
  const auto refuse = [&](const std::string& what) {
    throw unsupported_picture(path, what, "save it as a TIFF file of gray numbers or RGB colors");
  };
  const bool number = l.format == SAMPLEFORMAT_UINT ? l.bits >= 1 && (l.bits <= 32 || l.bits == 64)
                      : l.format == SAMPLEFORMAT_INT
                          ? l.bits == 8 || l.bits == 16 || l.bits == 32 || l.bits == 64
                          : l.format == SAMPLEFORMAT_IEEEFP && (l.bits == 16 || l.bits == 32 || l.bits == 64);
  if (!number || l.samples < 1 || l.samples > 10000)
    refuse(fmt::format("has {} samples of {} bits per pixel in the TIFF sample format {}", l.samples, l.bits,
                       l.format));
  if (l.photometric > PHOTOMETRIC_YCBCR)
    refuse(fmt::format("stores colors of the TIFF kind {} (PhotometricInterpretation)", l.photometric));
  if ((l.photometric == PHOTOMETRIC_YCBCR && l.compression != COMPRESSION_JPEG) ||
      l.compression == COMPRESSION_OJPEG)
    refuse("stores brightness and color differences (YCbCr)");
}

double half_float(std::uint64_t bits) {
  const int exponent = bits >> 10 & 31;
  const double fraction = bits & 1023, sign = bits >> 15 & 1 ? -1 : 1;
  if (exponent == 0) return sign * std::ldexp(fraction, -24);
  if (exponent < 31) return sign * std::ldexp(1024 + fraction, exponent - 25);
  return fraction == 0 ? sign * HUGE_VAL : std::nan("");
}

// Sample number i of a row. Whole bytes are in the order `little`; other widths count from the highest bit.
std::uint64_t row_bits(const unsigned char* row, std::uint64_t i, int bits, bool little) {
  std::uint64_t v = 0;
  if (bits % 8 == 0) {
    const int bytes = bits / 8;
    const unsigned char* p = row + i * bytes;
    for (int k = 0; k < bytes; ++k) v = v << 8 | p[little ? bytes - 1 - k : k];
    return v;
  }
  for (std::uint64_t b = i * bits, end = b + bits; b < end; ++b) v = v << 1 | (row[b / 8] >> (7 - b % 8) & 1);
  return v;
}

double sample_number(std::uint64_t bits, const TiffLayout& l, const std::filesystem::path& path) {
  if (l.format == SAMPLEFORMAT_IEEEFP)
    return l.bits == 16   ? half_float(bits)
           : l.bits == 32 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                          : std::bit_cast<double>(bits);
  const auto inexact = [&](const std::string& value) {
    return Error("bad-values", fmt::format("'{}' contains the number {}, above 2^53", path.string(), value),
                 "renumber it with smaller numbers")
        .parameter("path");
  };
  if (l.format == SAMPLEFORMAT_INT) {
    const auto value = static_cast<std::int64_t>(bits << (64 - l.bits)) >> (64 - l.bits);
    if (std::abs(static_cast<double>(value)) > kExact) throw inexact(fmt::format("{}", value));
    return value;
  }
  if (bits > static_cast<std::uint64_t>(kExact)) throw inexact(fmt::format("{}", bits));
  return bits;
}

// Copies a block of rows, each of `stride` bytes, to the samples that begin with pixel (x0, y0) and sample
// s0.
void copy_block(const unsigned char* block, std::uint64_t stride, int x0, int y0, int width, int height,
                int s0, bool little, const TiffLayout& l, const std::filesystem::path& path,
                StoredSamples& out) {
  const int together = l.together();
  const int right = std::min(out.width, x0 + width), below = std::min(out.height, y0 + height);
  for (int y = y0; y < below; ++y) {
    const unsigned char* row = block + (y - y0) * stride;
    for (int x = x0; x < right; ++x) {
      double* to = &out.values[(pixel_at(x, y, out.width)) * static_cast<std::size_t>(out.count) + s0];
      for (int s = 0; s < together; ++s)
        to[s] = sample_number(
            row_bits(row, static_cast<std::uint64_t>(x - x0) * static_cast<std::uint64_t>(together) + s,
                     l.bits, little),
            l, path);
    }
  }
}

// The pixels of a page that has no directory of its own: uncompressed, after those of the first page.
void read_following(const PictureContent& c, const TiffReader& in, const TiffDirectory& d,
                    const TiffLayout& l, std::uint64_t skip, StoredSamples& out) {
  const std::uint64_t first = in.value(d, tiff::kStripOffsets, 0) + skip;
  const std::uint64_t row =
      (static_cast<std::uint64_t>(l.width) * static_cast<std::uint64_t>(l.together()) * l.bits + 7) / 8;
  const std::uint64_t plane = row * l.height;
  const std::uint64_t planes = l.separate ? static_cast<std::uint64_t>(l.samples) : 1;
  if (first > c.bytes.size() || plane * planes > c.bytes.size() - first)
    throw unreadable_picture(c.path, "its pages end beyond the file");
  for (std::uint64_t s = 0; s < planes; ++s)
    copy_block(reinterpret_cast<const unsigned char*>(c.bytes.data()) + first + s * plane, row, 0, 0, l.width,
               l.height, s, in.is_little(), l, c.path, out);
}

class BlockReader {
 public:
  BlockReader(const PictureContent& c, TIFF* in, TiffSource& source, const TiffLayout& l,
              const Reading& reading, StoredSamples& out)
      : content_(c), in_(in), source_(source), layout_(l), reading_(reading), out_(out) {}

  void read() {
    const int planes = layout_.separate ? layout_.samples : 1;
    for (int s = 0; s < planes; ++s) TIFFIsTiled(in_) ? tiles(s) : strips(s);
  }

 private:
  void tiles(int s) {
    std::uint32_t width = 0, height = 0;
    TIFFGetField(in_, TIFFTAG_TILEWIDTH, &width);
    TIFFGetField(in_, TIFFTAG_TILELENGTH, &height);
    constexpr std::uint32_t kLongest = 1u << 30;
    if (width < 1 || height < 1) throw failure("its tiles are empty");
    width = std::min(width, kLongest);
    height = std::min(height, kLongest);
    block_.resize(size(TIFFTileSize64(in_)));
    const std::uint64_t stride = TIFFTileRowSize(in_);
    for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(layout_.height); y += height)
      for (std::uint32_t x = 0; x < static_cast<std::uint32_t>(layout_.width); x += width) {
        const auto tile = TIFFComputeTile(in_, x, y, 0, static_cast<std::uint16_t>(s));
        require(TIFFReadEncodedTile(in_, tile, block_.data(), static_cast<tmsize_t>(block_.size())),
                block_.size());
        copy(stride, x, y, width, height, s);
      }
  }

  void strips(int s) {
    std::uint32_t rows = 0;
    TIFFGetFieldDefaulted(in_, TIFFTAG_ROWSPERSTRIP, &rows);
    rows = std::min<std::uint32_t>(std::max(rows, 1u), layout_.height);
    block_.resize(size(TIFFStripSize64(in_)));
    const std::uint64_t stride = TIFFScanlineSize(in_);
    for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(layout_.height); y += rows) {
      const auto height = std::min(rows, layout_.height - y);
      require(TIFFReadEncodedStrip(in_, TIFFComputeStrip(in_, y, static_cast<std::uint16_t>(s)),
                                   block_.data(), static_cast<tmsize_t>(block_.size())),
              stride * height);
      copy(stride, 0, y, layout_.width, height, s);
    }
  }

  // Room for a block. Nothing that libtiff computes is trusted to agree with the layout.
  std::size_t size(std::uint64_t bytes) const {
    const double most = 16 + double(layout_.together()) * layout_.bits / 8 * (layout_.width + 65536.0) *
                                 (layout_.height + 65536.0);
    if (bytes < 1 || double(bytes) > most) throw failure("its blocks have no sensible size");
    require_memory(bytes, reading_.memory, "a block of the image");
    return bytes;
  }

  void require(tmsize_t got, std::uint64_t expected) const {
    if (got < 0) throw failure(source_.error.empty() ? "a block cannot be decoded" : source_.error);
    if (static_cast<std::uint64_t>(got) < expected)
      throw failure(fmt::format("a block has {} of {} bytes", got, expected));
  }

  void copy(std::uint64_t stride, int x, int y, int width, int height, int s) {
    if (stride * 8 < static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(layout_.together()) *
                         layout_.bits ||
        stride * height > block_.size())
      throw failure("its rows have no sensible size");
    copy_block(block_.data(), stride, x, y, width, height, s, std::endian::native == std::endian::little,
               layout_, content_.path, out_);
  }

  Error failure(const std::string& why) const { return unreadable_picture(content_.path, why); }

  const PictureContent& content_;
  TIFF* in_;
  TiffSource& source_;
  const TiffLayout& layout_;
  const Reading& reading_;
  StoredSamples& out_;
  std::vector<unsigned char> block_;
};

void read_blocks(const PictureContent& c, const PicturePage& page, const TiffLayout& l,
                 const Reading& reading, StoredSamples& out) {
  TiffSource source{c.bytes, 0, {}, {}};
  const OpenTiff in = open_tiff(source);
  if (!in || !TIFFSetSubDirectory(in.get(), page.directory))
    throw unreadable_picture(c.path, source.error.empty() ? "its directory cannot be read" : source.error);
  if (l.photometric == PHOTOMETRIC_YCBCR) TIFFSetField(in.get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  source.warning.clear();  // of tags that do not matter
  BlockReader(c, in.get(), source, l, reading, out).read();
  if (!source.warning.empty()) reading.warn(c.path.filename().string() + ": " + source.warning);
}

void take_palette(const TiffReader& in, const TiffDirectory& d, const PictureContent& c, StoredSamples& out) {
  const auto map = d.entries.find(tiff::kColorMap);
  const std::uint64_t colors = out.bits <= 16 ? std::uint64_t{1} << out.bits : 0;
  if (map == d.entries.end() || map->second.width != 2 || colors == 0 || map->second.count < 3 * colors)
    throw unreadable_picture(c.path, "it has no valid palette");
  out.palette.resize(colors);
  for (std::uint64_t i = 0; i < colors; ++i)
    for (std::uint64_t k = 0; k < 3; ++k) out.palette[i][k] = in.value(map->second, k * colors + i) >> 8;
}

}  // namespace

StoredSamples tiff_description(const PictureContent& c, const PicturePage& page) {
  const TiffReader in(c.bytes);
  const TiffDirectory d = in.directory(page.directory);
  const TiffLayout l = tiff_layout(in, d);
  StoredSamples out;
  out.width = l.width;
  out.height = l.height;
  out.count = l.samples;
  out.bits = l.bits;
  out.is_float = l.format == SAMPLEFORMAT_IEEEFP;
  out.white_is_zero = l.photometric == PHOTOMETRIC_MINISWHITE;
  out.is_lossy = is_lossy_compression(l.compression);
  out.is_color = (l.photometric == PHOTOMETRIC_RGB || l.photometric == PHOTOMETRIC_YCBCR) && l.samples >= 3;
  out.kind = l.photometric == PHOTOMETRIC_SEPARATED                         ? ColorKind::Ink
             : l.photometric >= PHOTOMETRIC_CIELAB && l.photometric < 32768 ? ColorKind::Lab
             : l.photometric == PHOTOMETRIC_PALETTE                         ? ColorKind::Palette
                                                                            : ColorKind::Plain;
  for (std::size_t i = 0; i < l.extra.size() && count_of(l.extra) < l.samples; ++i)
    if (l.extra[i] == EXTRASAMPLE_ASSOCALPHA || l.extra[i] == EXTRASAMPLE_UNASSALPHA)
      out.alpha = l.samples - static_cast<int>(l.extra.size() - i);
  return out;
}

StoredSamples stored_tiff(const PictureContent& c, const PicturePage& page, const Reading& reading,
                          double more) {
  const TiffReader in(c.bytes);
  const TiffDirectory d = in.directory(page.directory);
  const TiffLayout l = tiff_layout(in, d);
  require_supported(l, c.path);
  StoredSamples out = tiff_description(c, page);
  // 8: samples of less than a byte
  allocate_samples(out, c, l.width, l.height, 8 * largest_ratio("tiff", tiff_compression(l.compression)),
                   reading, more);
  if (page.skip > 0)
    read_following(c, in, d, l, page.skip, out);
  else
    read_blocks(c, page, l, reading, out);
  if (out.kind == ColorKind::Palette) take_palette(in, d, c, out);
  return out;
}

}  // namespace terrazzo
