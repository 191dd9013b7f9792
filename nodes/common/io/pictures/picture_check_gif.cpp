#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

// The blocks of a GIF file up to its trailer.
class GifBlocks {
 public:
  explicit GifBlocks(std::string_view content) : content_(content) {
    constexpr std::size_t kHeader = 13;
    need(kHeader);
    screen_width = number(6);
    screen_height = number(8);
    at_ = kHeader;
    skip_palette(byte(10));
  }

  void read() {
    while (true) {
      need(1);
      const unsigned kind = byte(at_++);
      constexpr unsigned kExtension = 0x21, kImage = 0x2c, kTrailer = 0x3b;
      if (kind == kTrailer) return;
      if (kind == kImage) {
        read_image();
      } else if (kind == kExtension) {
        need(1);
        ++at_;
        skip_parts();
      } else {
        damaged_picture(fmt::format("it has an unknown block at byte {}", at_ - 1));
      }
    }
  }

  unsigned screen_width = 0, screen_height = 0;
  int frames = 0;
  double pixels = 0;

 private:
  unsigned byte(std::size_t at) const { return static_cast<unsigned char>(content_[at]); }
  unsigned number(std::size_t at) const { return byte(at) | byte(at + 1) << 8; }
  void need(std::size_t bytes) const {
    if (bytes > content_.size() - at_)
      damaged_picture(fmt::format("it is truncated at byte {}", content_.size()));
  }
  void skip_palette(unsigned flags) {
    if (!(flags & 0x80)) return;
    const std::size_t bytes = 3u << ((flags & 7) + 1);
    need(bytes);
    at_ += bytes;
  }
  // Parts of up to 255 bytes; an empty one ends them.
  void skip_parts() {
    while (true) {
      need(1);
      const std::size_t length = byte(at_++);
      if (length == 0) return;
      need(length);
      at_ += length;
    }
  }
  void read_image() {
    need(9);
    const unsigned right = number(at_) + number(at_ + 4), below = number(at_ + 2) + number(at_ + 6);
    if (right > screen_width || below > screen_height)
      damaged_picture(fmt::format("frame {} lies outside of the picture", frames + 1));
    pixels += double(number(at_ + 4)) * number(at_ + 6);
    const unsigned flags = byte(at_ + 8);
    at_ += 9;
    skip_palette(flags);
    need(1);
    ++at_;
    skip_parts();
    ++frames;
  }

  std::string_view content_;
  std::size_t at_ = 0;
};

}  // namespace

int gif_frames(std::string_view content) {
  GifBlocks blocks(content);
  blocks.read();
  return blocks.frames;
}

void check_gif(std::string_view content, const Reading& reading) {
  GifBlocks blocks(content);
  blocks.read();
  if (blocks.frames == 0) damaged_picture("it has no frames");
  if (blocks.pixels > largest_ratio("gif", "") * content.size() + 1e6)
    damaged_picture(fmt::format("{} bytes cannot hold {:.0f} pixels", content.size(), blocks.pixels));
  require_memory(2 * blocks.pixels, reading.memory,
                 fmt::format("a picture of {} × {} pixels and {} frames", blocks.screen_width,
                             blocks.screen_height, blocks.frames));
}

}  // namespace terrazzo
