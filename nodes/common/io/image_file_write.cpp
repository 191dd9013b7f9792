#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/common/io/image_file.h"
#include "nodes/common/texture/color.h"
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
float dither(std::size_t pixel) {
  return (static_cast<float>(mix64(pixel) >> 40) * 0x1p-24f - 0.5f) * 0.998f;
}

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
  const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
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
      image.pixels.size() != static_cast<std::size_t>(image.width) * image.height * image.sections)
    throw Error("empty-image", "section " + std::to_string(section) + " does not exist in an image of " +
                                   std::to_string(image.width) + " × " + std::to_string(image.height) +
                                   " pixels and " + std::to_string(image.sections) + " sections");
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  const Vec3f* pixels = image.pixels.data() + count * section;
  for (std::size_t p = 0; p < count; ++p)
    if (pixels[p].hasNaN())
      throw Error("bad-pixels", "the image contains NaN at column " + std::to_string(p % image.width) +
                                    ", row " + std::to_string(p / image.width));
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  auto out = OIIO::ImageOutput::create(path.string());
  if (!out) throw unwritable(path, OIIO::geterror());

  const bool linear = extension == ".exr" || extension == ".hdr";
  const bool deep = extension == ".tif" || extension == ".tiff";
  OIIO::ImageSpec spec(image.width, image.height, 3,
                       linear ? OIIO::TypeDesc::FLOAT
                       : deep ? OIIO::TypeDesc::UINT16
                              : OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", linear ? "Linear" : "sRGB");
  if (extension == ".exr") spec.attribute("compression", "zip");
  if (extension == ".jpg" || extension == ".jpeg") {
    spec.attribute("compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");
  }
  // JPEG stores this as Exif, which is limited to 64 KiB.
  if (!provenance.empty() &&
      (provenance.size() < 60000 || extension == ".png" || extension == ".exr" || deep))
    spec.attribute("ImageDescription", provenance);
  // Encode to memory and write the file here: on a full disk libjpeg would end the program, and other formats
  // report no error. (TIFF reports errors, and cannot write Exif to memory.)
  OIIO::Filesystem::IOVecOutput memory;
  const bool in_memory = !deep && out->supports("ioproxy") && out->set_ioproxy(&memory);
  if (!out->open(path.string(), spec)) throw unwritable(path, out->geterror());

  bool written = false;
  if (linear)
    written = out->write_image(OIIO::TypeDesc::FLOAT, pixels);
  else if (deep)
    written = out->write_image(OIIO::TypeDesc::UINT16,
                               quantize<std::uint16_t>(encode(pixels, count, 65535), 65535, [](std::size_t) {
                                 return 0.0f;
                               }).data());
  else
    written = out->write_image(OIIO::TypeDesc::UINT8, dithered(pixels, image.width, image.height).data());
  if (!written) throw unwritable(path, out->geterror());
  if (!out->close()) throw unwritable(path, out->geterror());
  if (!in_memory) return;
  try {
    write_bytes(path, {reinterpret_cast<const char*>(memory.buffer().data()), memory.buffer().size()});
  } catch (const Error& e) {
    throw unwritable(path, e.diagnostic().message);
  }
}

}  // namespace terrazzo
