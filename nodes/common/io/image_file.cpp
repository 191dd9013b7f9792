#include "nodes/common/io/image_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "graph/diagnostic.h"
#include "nodes/common/io/color_config.h"
#include "nodes/common/io/picture_input.h"
#include "nodes/common/texture/color.h"

namespace terrazzo {
namespace {

// The channels with red, green, blue and alpha; alpha is −1 if there is none.
struct Channels {
  int rgb[3] = {0, 0, 0};
  int alpha = -1;
};

Channels channels_of(const PictureHeader& spec) {
  Channels c;
  c.alpha = spec.alpha >= 0 && spec.alpha < spec.count() && spec.count() > 1 ? spec.alpha : -1;
  int found[3] = {-1, -1, -1};
  for (int i = 0; i < spec.count(); ++i)
    for (int k = 0; k < 3; ++k)
      if (spec.channels[i] == std::string(1, "RGB"[k])) found[k] = i;
  if (found[0] >= 0 && found[1] >= 0 && found[2] >= 0) {
    std::copy(found, found + 3, c.rgb);
  } else {
    const int colors = spec.count() - (c.alpha >= 0 ? 1 : 0);
    for (int k = 0; k < 3; ++k) c.rgb[k] = colors >= 3 ? k : 0;
  }
  return c;
}

// Converts samples to floats through a table, which makes 8 and 16 bit images as fast as a copy.
template <class T>
void decode(const std::vector<T>& samples, int stride, const Channels& c, const std::vector<float>& table,
            Image& image) {
  for (std::size_t p = 0; p < image.pixels.size(); ++p)
    for (int k = 0; k < 3; ++k) image.pixels[p][k] = table[samples[p * stride + c.rgb[k]]];
}

std::vector<float> decoding_table(std::size_t size, bool srgb) {
  std::vector<float> table(size);
  for (std::size_t i = 0; i < size; ++i) {
    const float v = static_cast<float>(i) / static_cast<float>(size - 1);
    table[i] = srgb ? srgb_to_linear(Vec3f::Constant(v))[0] : v;
  }
  return table;
}

// EXIF orientation: pixel (x, y) of the upright image is in.at(u, v).
Image upright(Image in, int orientation) {
  if (orientation < 2 || orientation > 8) return in;
  const bool swapped = orientation >= 5;
  Image out(swapped ? in.height : in.width, swapped ? in.width : in.height, 1, in.pixel_size);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      int u = swapped ? y : x, v = swapped ? x : y;
      if (orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8) u = in.width - 1 - u;
      if (orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7) v = in.height - 1 - v;
      out.at(x, y) = in.at(u, v);
    }
  return out;
}

}  // namespace

Image read_image(const std::filesystem::path& path, const std::string& colorspace, double pixel_size,
                 const Reading& reading, std::optional<PixelScale>* scale) {
  // Otherwise the decoder multiplies encoded values by alpha.
  PictureInput in(path, reading, {{"oiio:UnassociatedAlpha", 1}});
  const PictureHeader spec = in.header();
  if (spec.deep) throw in.unreadable("deep images have no single color per pixel");
  if (scale) *scale = pixel_scale_of(in.attributes());
  // The image, its upright copy, and alpha.
  constexpr double more = 2 * sizeof(Vec3f) + sizeof(float);

  const Channels channels = channels_of(spec);
  const bool is_float = spec.is_float;
  const bool automatic = colorspace == "auto";
  std::vector<float> alpha;
  Image image;
  const auto make_room = [&] { image = Image(spec.width, spec.height, 1, pixel_size); };
  auto take_alpha = [&](const auto& samples, float scale) {
    if (channels.alpha < 0) return;
    alpha.resize(image.pixels.size());
    for (std::size_t p = 0; p < alpha.size(); ++p)
      alpha[p] = static_cast<float>(samples[p * spec.count() + channels.alpha]) * scale;
  };
  if (spec.sample == Sample::UInt8) {
    const auto samples = in.samples<std::uint8_t>(Sample::UInt8, more);
    make_room();
    decode(samples, spec.count(), channels, decoding_table(256, automatic), image);
    take_alpha(samples, 1 / 255.0f);
  } else if (!is_float) {
    const auto samples = in.samples<std::uint16_t>(Sample::UInt16, more);
    make_room();
    decode(samples, spec.count(), channels, decoding_table(65536, automatic), image);
    take_alpha(samples, 1 / 65535.0f);
  } else {
    const auto samples = in.samples<float>(Sample::Float, more);
    make_room();
    for (std::size_t p = 0; p < image.pixels.size(); ++p)
      for (int k = 0; k < 3; ++k) image.pixels[p][k] = samples[p * spec.count() + channels.rgb[k]];
    take_alpha(samples, 1);
    for (std::size_t p = 0; p < image.pixels.size(); ++p)
      if (!image.pixels[p].allFinite())
        throw Error("bad-pixels",
                    "'" + path.string() + "' contains NaN or infinity at column " +
                        std::to_string(p % spec.width) + ", row " + std::to_string(p / spec.width),
                    "replace those pixels before reading the image")
            .parameter("path");
  }
  const char* environment = std::getenv("OCIO");
  if (!automatic)
    to_linear_rec709(image.pixels.data(), image.width, image.height, colorspace);
  else if (is_float && environment && *environment)  // scene-linear as defined by that configuration
    to_linear_rec709(image.pixels.data(), image.width, image.height, "scene_linear");
  if (const auto clear = std::count(alpha.begin(), alpha.end(), 0.0f); clear > 0)
    reading.warn(
        "'" + printable(path.filename().string()) + "': " +
        std::to_string(std::max<std::int64_t>(1, 100 * clear / static_cast<std::int64_t>(alpha.size()))) +
        " % of the pixels are transparent and become black; cut them off, or tell Segment to ignore them");
  // Composite over black. If the file's color is already premultiplied by alpha, there is nothing to do.
  if (!alpha.empty() && in.attributes().whole("oiio:UnassociatedAlpha", 0) != 0)
    for (std::size_t p = 0; p < alpha.size(); ++p) image.pixels[p] *= alpha[p];
  return upright(std::move(image), in.attributes().whole("Orientation", 1));
}

}  // namespace terrazzo
