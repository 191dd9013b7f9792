#include <fmt/format.h>
#include <gif_lib.h>

#include <cstring>
#include <memory>

#include "nodes/common/io/pictures/stored_picture.h"

namespace terrazzo {
namespace {

struct GifSource {
  std::string_view left;
};

int gif_take(GifFileType* gif, GifByteType* to, int size) {
  auto& s = *static_cast<GifSource*>(gif->UserData);
  const std::size_t n = std::min<std::size_t>(s.left.size(), std::max(size, 0));
  std::memcpy(to, s.left.data(), n);
  s.left.remove_prefix(n);
  return n;
}

struct CloseGif {
  void operator()(GifFileType* gif) const { DGifCloseFile(gif, nullptr); }
};

// The color index that the frame declares to be transparent, or −1.
int clear_color(GifFileType* gif, int frame) {
  GraphicsControlBlock block;
  return DGifSavedExtensionToGCB(gif, frame, &block) == GIF_OK ? block.TransparentColor
                                                               : NO_TRANSPARENT_COLOR;
}

}  // namespace

StoredSamples stored_gif(const PictureContent& c, const PicturePage& page, const Reading& reading,
                         double more) {
  GifSource source{c.bytes};
  int error = 0;
  const std::unique_ptr<GifFileType, CloseGif> gif(DGifOpen(&source, gif_take, &error));
  const auto failure = [&](int code) {
    const char* text = GifErrorString(code);
    return unreadable_picture(c.path, text ? text : "a block cannot be decoded");
  };
  if (!gif) throw failure(error);
  StoredSamples out;
  // A code of 12 bits stands for up to 4,096 pixels. `more`: the frames, which giflib keeps.
  allocate_samples(out, c, gif->SWidth, gif->SHeight, 3000, reading, more + double(c.pages.pages.size()));
  if (DGifSlurp(gif.get()) != GIF_OK) throw failure(gif->Error);
  if (page.number < 0 || page.number >= gif->ImageCount) throw failure(D_GIF_ERR_NO_IMAG_DSCR);
  const SavedImage& frame = gif->SavedImages[page.number];
  const GifImageDesc& place = frame.ImageDesc;
  const int clear = clear_color(gif.get(), page.number);
  if (place.Left != 0 || place.Top != 0 || place.Width != out.width || place.Height != out.height ||
      (page.number > 0 && clear != NO_TRANSPARENT_COLOR))
    throw unsupported_picture(
        c.path, fmt::format("stores frame {} as a change of the frames before it", page.number + 1),
        "save the frame to read as PNG");
  const ColorMapObject* colors = place.ColorMap ? place.ColorMap : gif->SColorMap;
  if (!colors) throw unreadable_picture(c.path, "it has no palette");
  for (int i = 0; i < colors->ColorCount; ++i)
    out.palette.push_back({colors->Colors[i].Red, colors->Colors[i].Green, colors->Colors[i].Blue});
  if (clear >= 0 && clear < 256) {
    out.palette_alpha.assign(clear + 1, 255);
    out.palette_alpha.back() = 0;
  }
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = frame.RasterBits[i];
  return out;
}

}  // namespace terrazzo
