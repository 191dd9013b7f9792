#include <fmt/format.h>
#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstring>

#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/stored_picture.h"

namespace terrazzo {
namespace {

// State for libpng's callbacks. libpng reports errors by longjmp, so no object with a destructor may live
// between setjmp and the calls.
struct PngSource {
  const char* at;
  std::size_t left;
  char error[200] = "";
};

void png_take(png_structp png, png_bytep to, std::size_t size) {
  auto& s = *static_cast<PngSource*>(png_get_io_ptr(png));
  if (size > s.left) png_error(png, "it is truncated");
  std::memcpy(to, s.at, size);
  s.at += size;
  s.left -= size;
}

void png_failed(png_structp png, png_const_charp message) {
  auto& s = *static_cast<PngSource*>(png_get_error_ptr(png));
  std::strncpy(s.error, message, sizeof s.error - 1);
  std::longjmp(png_jmpbuf(png), 1);
}

void png_ignored(png_structp, png_const_charp) {}  // about metadata; check_png() verified the rest

struct PngHeader {
  png_uint_32 width = 0;
  png_uint_32 height = 0;
  int depth = 8, kind = 0, channels = 1;
  std::size_t row = 0;  // bytes
  png_colorp colors = nullptr;
  int color_count = 0;
  png_bytep alpha = nullptr;
  int alpha_count = 0;
  png_color_16p clear = nullptr;
};

// False if libpng reports an error.
bool png_begin(png_structp png, png_infop info, PngHeader& h) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_info(png, info);
  png_get_IHDR(png, info, &h.width, &h.height, &h.depth, &h.kind, nullptr, nullptr, nullptr);
  png_set_packing(png);  // a byte for each sample of less than 8 bits, unchanged
  if (h.depth == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  if (h.kind == PNG_COLOR_TYPE_PALETTE) png_get_PLTE(png, info, &h.colors, &h.color_count);
  if (png_get_valid(png, info, PNG_INFO_tRNS)) {
    png_get_tRNS(png, info, &h.alpha, &h.alpha_count, &h.clear);
    if (h.kind == PNG_COLOR_TYPE_RGB) png_set_tRNS_to_alpha(png);
  }
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  h.channels = png_get_channels(png, info);
  h.row = png_get_rowbytes(png, info);
  return true;
}

bool png_rows(png_structp png, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_image(png, rows);
  return true;
}

// Frees what libpng allocated.
struct OpenPng {
  png_structp png;
  png_infop info;
  explicit OpenPng(PngSource& source)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, png_failed, png_ignored)),
        info(png ? png_create_info_struct(png) : nullptr) {
    if (!info) throw std::bad_alloc();
    png_set_read_fn(png, &source, png_take);
  }
  OpenPng(const OpenPng&) = delete;
  ~OpenPng() { png_destroy_read_struct(&png, &info, nullptr); }
};

StoredSamples png_description(const PngHeader& h) {
  StoredSamples out;
  out.count = h.channels;
  out.bits = h.depth;
  out.is_color = h.channels >= 3;
  if (h.channels == 2 || h.channels == 4) out.alpha = h.channels - 1;
  for (int i = 0; i < h.color_count; ++i)
    out.palette.push_back({h.colors[i].red, h.colors[i].green, h.colors[i].blue});
  if (h.kind == PNG_COLOR_TYPE_PALETTE && h.alpha) out.palette_alpha.assign(h.alpha, h.alpha + h.alpha_count);
  if (h.kind == PNG_COLOR_TYPE_GRAY && h.clear) out.clear = h.clear->gray;
  return out;
}

}  // namespace

StoredSamples stored_png(const PictureContent& c, const Reading& reading, double more) {
  PngSource source{c.bytes.data(), c.bytes.size()};
  OpenPng open(source);
  PngHeader h;
  if (!png_begin(open.png, open.info, h)) throw unreadable_picture(c.path, printable(source.error));
  StoredSamples out = png_description(h);
  const std::size_t sample = h.depth == 16 ? 2 : 1;
  if (h.row != std::size_t{h.width} * h.channels * sample)
    throw unreadable_picture(c.path, "its rows have no sensible size");
  allocate_samples(out, c, h.width, h.height, largest_ratio("png", ""), reading,
                   more + double(sample) * h.channels + 8);
  std::vector<png_byte> bytes(h.row * h.height);
  std::vector<png_bytep> rows(h.height);
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = &bytes[y * h.row];
  if (!png_rows(open.png, rows.data())) throw unreadable_picture(c.path, printable(source.error));
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    std::uint16_t wide = 0;
    if (sample == 2) std::memcpy(&wide, &bytes[2 * i], 2);
    out.values[i] = sample == 2 ? wide : bytes[i];
  }
  return out;
}

}  // namespace terrazzo
