#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/common/io/image_file.h"
#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

Error unwritable(const std::filesystem::path& path, std::string why) {
  while (!why.empty() && (why.back() == '\n' || why.back() == ' ')) why.pop_back();
  return Error("unwritable-image", "cannot write the image '" + path.string() + "': " + why,
               "check the folder, the free disk space and the extension");
}

// Uniform noise in (−½, ½) from the pixel's index, so that smooth gradients show no bands. Values that the
// format represents exactly are preserved.
float dither(std::size_t pixel) { return ((mix64(pixel) >> 40) * 0x1p-24f - 0.5f) * 0.998f; }

// Encoded sRGB times `top`.
std::vector<Vec3f> encode(const Vec3f* pixels, std::size_t count, float top) {
  std::vector<Vec3f> out(count);
  for (std::size_t p = 0; p < count; ++p)
    out[p] = linear_to_srgb(pixels[p].cwiseMax(0.0f).cwiseMin(1.0f)) * top;
  return out;
}

// Values from 0 to `top` from encoded ones. `shift`: what is added to all channels of a pixel before they are
// rounded.
template <class T, class Shift>
std::vector<T> quantize(const std::vector<Vec3f>& encoded, float top, const Shift& shift) {
  std::vector<T> out(encoded.size() * 3);
  for (std::size_t p = 0; p < encoded.size(); ++p) {
    const float s = shift(p);
    for (int k = 0; k < 3; ++k)
      out[p * 3 + k] = static_cast<T>(std::clamp(std::floor(encoded[p][k] + 0.5f + s), 0.0f, top));
  }
  return out;
}

// 8 bits. Dithers where neighbors differ by less than a step, since only there bands can show; grain needs no
// more noise. All channels of a pixel get the same, so gray stays gray.
std::vector<std::uint8_t> dithered(const Vec3f* pixels, int width, int height) {
  const std::size_t w = width, h = height;
  const std::vector<Vec3f> encoded = encode(pixels, w * h, 255);
  return quantize<std::uint8_t>(encoded, 255, [&](std::size_t p) {
    const auto step = [&](std::size_t q) { return (encoded[p] - encoded[q]).cwiseAbs().maxCoeff() >= 1; };
    const std::size_t x = p % w, y = p / w;
    const bool rough = (x > 0 && step(p - 1)) || (x + 1 < w && step(p + 1)) || (y > 0 && step(p - w)) ||
                       (y + 1 < h && step(p + w));
    return rough ? 0.0f : dither(p);
  });
}

}  // namespace

void write_image(const std::filesystem::path& path, const Image& image, int section,
                 const std::string& provenance) {
  if (section < 0 || section >= image.sections || image.width <= 0 || image.height <= 0 ||
      image.pixels.size() != pixels_in(image.width, image.height) * image.sections)
    throw Error("empty-image", "section " + std::to_string(section) + " does not exist in an image of " +
                                   std::to_string(image.width) + " × " + std::to_string(image.height) +
                                   " pixels and " + std::to_string(image.sections) + " sections");
  const std::size_t count = pixels_in(image.width, image.height);
  const Vec3f* pixels = image.pixels.data() + count * section;
  for (std::size_t p = 0; p < count; ++p)
    if (pixels[p].hasNaN())
      throw Error("bad-pixels", "the image contains NaN at column " + std::to_string(p % image.width) +
                                    ", row " + std::to_string(p / image.width));
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const bool linear = extension == ".exr" || extension == ".hdr";
  const bool deep = extension == ".tif" || extension == ".tiff";
  PictureEncoding encoding;
  encoding.width = image.width;
  encoding.height = image.height;
  encoding.sample = linear ? Sample::Float : deep ? Sample::UInt16 : Sample::UInt8;
  auto& attributes = encoding.attributes;
  attributes.emplace_back("oiio:ColorSpace", linear ? "Linear" : "sRGB");
  if (extension == ".exr") attributes.emplace_back("compression", "zip");
  if (extension == ".jpg" || extension == ".jpeg") {
    attributes.emplace_back("compression", "jpeg:95");
    attributes.emplace_back("jpeg:subsampling", "4:4:4");
  }
  // JPEG stores this as Exif, which is limited to 64 KiB.
  if (!provenance.empty() &&
      (provenance.size() < 60000 || extension == ".png" || extension == ".exr" || deep))
    attributes.emplace_back("ImageDescription", provenance);

  const PictureCodec& codec = picture_codec();
  std::string bytes;
  try {
    if (linear)
      bytes = codec.encode(path, encoding, pixels);
    else if (deep)
      bytes = codec.encode(path, encoding,
                           quantize<std::uint16_t>(encode(pixels, count, 65535), 65535, [](std::size_t) {
                             return 0.0f;
                           }).data());
    else
      bytes = codec.encode(path, encoding, dithered(pixels, image.width, image.height).data());
  } catch (const std::runtime_error& e) {
    throw unwritable(path, e.what());
  }
  if (bytes.empty()) return;  // written already
  try {
    write_bytes(path, bytes);
  } catch (const Error& e) {
    throw unwritable(path, e.diagnostic().message);
  }
}

}  // namespace terrazzo
