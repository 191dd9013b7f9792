#include <fmt/format.h>

#include <csetjmp>
#include <cstdio>  // before jpeglib.h, which needs FILE

#include <jerror.h>
#include <jpeglib.h>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

constexpr int kMostScans = 500;  // progressive files have about ten; thousands only cost time

// State for libjpeg's callbacks. libjpeg reports errors by longjmp, so no object with a destructor may live
// between setjmp and the calls.
struct Listener {
  jpeg_error_mgr manager;
  jpeg_progress_mgr progress;
  std::jmp_buf leave;
  char error[JMSG_LENGTH_MAX] = "";
  char first_warning[JMSG_LENGTH_MAX] = "";
  long warnings = 0;
  bool cut_short = false;
};

Listener& of(j_common_ptr c) { return *static_cast<Listener*>(c->client_data); }

void on_error(j_common_ptr c) {
  (*c->err->format_message)(c, of(c).error);
  std::longjmp(of(c).leave, 1);
}

void on_message(j_common_ptr c, int level) {
  if (level >= 0) return;  // a trace message
  Listener& l = of(c);
  if (l.warnings++ == 0) (*c->err->format_message)(c, l.first_warning);
  if (c->err->msg_code == JWRN_JPEG_EOF) l.cut_short = true;
}

void on_progress(j_common_ptr c) {
  if (reinterpret_cast<j_decompress_ptr>(c)->input_scan_number <= kMostScans) return;
  std::snprintf(of(c).error, sizeof of(c).error, "it has more than %d scans", kMostScans);
  std::longjmp(of(c).leave, 1);
}

struct Size {
  double width = 0, height = 0;
  int components = 0;
};

// Decodes at an eighth of the resolution, which reads every bit of the file. Returns false on an error.
bool decode(std::string_view content, jpeg_decompress_struct& c, Listener& l, Size& size, bool header_only) {
  if (setjmp(l.leave)) return false;
  jpeg_mem_src(&c, reinterpret_cast<const unsigned char*>(content.data()), content.size());
  jpeg_read_header(&c, TRUE);
  size.width = c.image_width;
  size.height = c.image_height;
  size.components = c.num_components;
  if (header_only) return true;
  c.scale_num = 1;
  c.scale_denom = 8;
  c.do_fancy_upsampling = FALSE;
  c.dct_method = JDCT_IFAST;
  c.out_color_space = c.jpeg_color_space;
  jpeg_start_decompress(&c);
  const JSAMPARRAY rows = (*c.mem->alloc_sarray)(reinterpret_cast<j_common_ptr>(&c), JPOOL_IMAGE,
                                                 c.output_width * c.output_components, 1);
  while (c.output_scanline < c.output_height) jpeg_read_scanlines(&c, rows, 1);
  jpeg_finish_decompress(&c);
  return true;
}

bool run(std::string_view content, Listener& l, Size& size, bool header_only) {
  jpeg_decompress_struct c = {};
  c.err = jpeg_std_error(&l.manager);
  l.manager.error_exit = on_error;
  l.manager.emit_message = on_message;
  c.client_data = &l;
  jpeg_create_decompress(&c);
  c.client_data = &l;
  l.progress.progress_monitor = on_progress;
  c.progress = &l.progress;
  const bool good = decode(content, c, l, size, header_only);
  jpeg_destroy_decompress(&c);
  return good;
}

}  // namespace

int jpeg_components(std::string_view content) {
  Size size;
  Listener l;
  return run(content, l, size, true) ? size.components : 0;
}

void check_jpeg(std::string_view content, const Reading& reading) {
  Size size;
  Listener header;
  if (!run(content, header, size, true)) damaged_picture(printable(header.error));
  const double samples = size.width * size.height * size.components;
  if (samples > largest_ratio("jpeg", "") * content.size() + 1e6)
    damaged_picture(
        fmt::format("{} bytes cannot hold {:.0f} × {:.0f} pixels", content.size(), size.width, size.height));
  require_memory(3 * samples, reading.memory,  // coefficients of a progressive file, and decoded samples
                 fmt::format("an image of {:.0f} × {:.0f} pixels", size.width, size.height));
  Listener l;
  if (!run(content, l, size, false)) damaged_picture(printable(l.error));
  if (l.cut_short) damaged_picture("it is truncated (" + printable(l.first_warning) + ")");
  if (l.warnings > 0)
    reading.warn(fmt::format("the JPEG decoder warned {} {}; first: {}", l.warnings,
                             l.warnings == 1 ? "time" : "times", printable(l.first_warning)));
}

}  // namespace terrazzo
