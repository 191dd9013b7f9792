#include "nodes/common/io/pictures/stored_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/io/pictures/orientation.h"
#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/picture_input.h"
#include "nodes/common/io/pictures/picture_metadata.h"

namespace terrazzo {
namespace {

template <class T>
void take_decoded(PictureInput& in, Sample type, double more, StoredSamples& out) {
  const auto samples = in.samples<T>(type, more + sizeof(double) * in.header().count());
  out.values.assign(samples.begin(), samples.end());
}

// Formats without palettes and scaled numbers: OpenImageIO gives the stored numbers if asked for their type.
StoredSamples stored_by_openimageio(const PictureContent& c, const PicturePage& page, const Reading& reading,
                                    double more) {
  PictureContent named{c.path, {}, c.format, {}};
  PictureInput in(std::move(named), c.bytes.size(), reading,
                  {{"oiio:RawColor", 1}, {"oiio:UnassociatedAlpha", 1}});
  if (!in.seek(page.number)) throw in.unreadable("it has no such page");
  const PictureHeader h = in.header();
  if (h.deep) throw in.unreadable("deep images have no single number per pixel");
  StoredSamples out;
  out.width = h.width;
  out.height = h.height;
  out.count = h.count();
  out.alpha = h.alpha >= 0 && h.count() > 1 ? h.alpha : -1;
  out.is_float = h.is_float;
  out.bits = 8 * h.sample_bytes;
  out.is_lossy = c.format == "jpeg";
  out.is_color = h.count() >= 3 && h.channels[0] == "R" && h.channels[1] == "G" && h.channels[2] == "B";
  if (h.sample == Sample::UInt8)
    take_decoded<std::uint8_t>(in, h.sample, more, out);
  else if (h.sample == Sample::UInt16)
    take_decoded<std::uint16_t>(in, h.sample, more, out);
  else if (h.sample == Sample::UInt32)
    take_decoded<std::uint32_t>(in, h.sample, more, out);
  else
    take_decoded<float>(in, Sample::Float, more, out);
  return out;
}

StoredSamples stored_as_written(const PictureContent& c, const PicturePage& page, const Reading& reading,
                                double more) {
  if (c.format == "tiff") return stored_tiff(c, page, reading, more);
  if (c.format == "png") return stored_png(c, reading, more);
  if (c.format == "gif") return stored_gif(c, page, reading, more);
  if (c.format == "bmp" && static_cast<unsigned char>(c.bytes[28]) <= 8) return stored_bmp(c, reading, more);
  if (c.format == "pnm" && c.bytes[1] >= '1' && c.bytes[1] <= '6') return stored_pnm(c, reading, more);
  if (c.format == "raw")
    throw unsupported_picture(c.path, "is the raw file of a camera, which has no stored numbers of its own",
                              "convert it to TIFF or PNG");
  return stored_by_openimageio(c, page, reading, more);
}

}  // namespace

void allocate_samples(StoredSamples& out, const PictureContent& c, double width, double height, double ratio,
                      const Reading& reading, double more) {
  constexpr double kLongest = 1 << 30;
  if (width < 1 || height < 1) throw unreadable_picture(c.path, "it is empty");
  const double pixels = width * height, samples = pixels * out.count;
  if (width > kLongest || height > kLongest ||
      samples * std::max(1.0, out.bits / 8.0) > ratio * c.bytes.size() + 1e6)
    throw unreadable_picture(c.path, fmt::format("{} bytes cannot hold {:.0f} × {:.0f} pixels of {} channels",
                                                 c.bytes.size(), width, height, out.count));
  try {
    require_memory(sizeof(double) * samples + pixels * more, reading.memory,
                   fmt::format("the image '{}' of {:.0f} × {:.0f} pixels", c.path.string(), width, height));
  } catch (Error& e) {
    throw e.parameter("path");
  }
  out.width = static_cast<int>(width);
  out.height = static_cast<int>(height);
  out.values.resize(samples);
}

StoredSamples stored_samples(const PictureContent& c, const PicturePage& page, const Reading& reading,
                             double more) {
  const int orientation = metadata_of(c, page).orientation;
  const double copy = orientation > 1 ? sizeof(double) : 0;
  StoredSamples out = stored_as_written(c, page, reading, more + copy);
  make_upright(out.values, out.width, out.height, out.count, orientation);
  return out;
}

}  // namespace terrazzo
