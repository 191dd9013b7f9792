#include "nodes/export/formats/picture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "nodes/common/io/checked_file.h"
#include "nodes/common/io/image_file.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::exporting {
namespace {

Error incomplete(std::string why) {
  while (!why.empty() && (why.back() == '\n' || why.back() == ' ')) why.pop_back();
  return Error("write-failed", "the image file is incomplete" + (why.empty() ? "" : ": " + why),
               "check the output folder and the free disk space");
}

std::string encode(const std::filesystem::path& path, const PictureEncoding& encoding, const void* samples) {
  const PictureCodec& codec = picture_codec();
  try {
    return codec.encode(path, encoding, samples);
  } catch (const std::runtime_error& e) {
    throw incomplete(e.what());
  }
}

// Decodes the whole file to check that it is complete.
void verify(const std::filesystem::path& path) {
  const PictureCodec& codec = picture_codec();
  std::unique_ptr<PictureDecoder> in;
  try {
    in = codec.open(path, "", {});
  } catch (const std::runtime_error& e) {
    throw incomplete(e.what());
  }
  const PictureHeader& header = in->header();
  std::vector<unsigned char> pixels(pixels_in(header.width, header.height) * header.channels.size() *
                                    header.sample_bytes);
  if (!in->read(header.sample, pixels.data())) throw incomplete(in->error());
}

}  // namespace

void write_picture(const std::filesystem::path& path, const Image& image, int section,
                   const std::string& provenance) {
  write_image(path, image, section, provenance);
  verify(path);
}

std::string png_of(const Image& image) {
  const std::size_t count = pixels_in(image.width, image.height);
  if (count == 0 || image.pixels.size() < count) throw Error("empty-image", "the image has no pixels");
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f c = linear_to_srgb(image.pixels[i].cwiseMax(0.0f).cwiseMin(1.0f));
    for (int k = 0; k < 3; ++k) bytes.push_back(std::lround(255 * c[k]));
  }
  PictureEncoding encoding;
  encoding.width = image.width;
  encoding.height = image.height;
  encoding.attributes = {{"oiio:ColorSpace", "sRGB"}};
  return encoded_png(encoding, bytes.data());
}

void write_samples(const std::filesystem::path& path, const PictureEncoding& encoding, const void* samples) {
  const std::string bytes = encode(path, encoding, samples);
  if (!bytes.empty()) write_bytes(path, bytes);
  verify(path);
}

std::string encoded_png(const PictureEncoding& encoding, const void* samples) {
  return encode("image.png", encoding, samples);
}

void write_labels(const std::filesystem::path& path, const Labels& labels, int section,
                  const std::string& provenance) {
  const std::size_t count = pixels_in(labels.width, labels.height);
  if (count == 0 || section < 0 || section >= labels.sections || labels.ids.size() != count * labels.sections)
    throw Error("empty-labels",
                fmt::format("the labels have no section {}: they have {} × {} pixels and {} sections",
                            section, labels.width, labels.height, labels.sections));
  const std::int32_t* ids = labels.ids.data() + count * section;
  const auto [low, high] = std::minmax_element(ids, ids + count);
  if (*low < 0) throw Error("bad-labels", fmt::format("label ids must not be negative; one is {}", *low));
  const bool png = path.extension() == ".png";
  if (png && *high > 65535)
    throw Error("too-many-labels", fmt::format("id {} does not fit the 16 bits of a .png", *high),
                "use .tif or .exr");

  PictureEncoding encoding;
  encoding.width = labels.width;
  encoding.height = labels.height;
  encoding.channels = 1;
  encoding.sample = png ? Sample::UInt16 : Sample::UInt32;
  encoding.attributes = {{"oiio:ColorSpace", "Raw"}};  // no gamma chunk: these are ids, not intensities
  if (!png) encoding.attributes.emplace_back("compression", "zip");
  if (!provenance.empty()) encoding.attributes.emplace_back("ImageDescription", provenance);
  if (png)
    write_samples(path, encoding, std::vector<std::uint16_t>(ids, ids + count).data());
  else
    write_samples(path, encoding, std::vector<std::uint32_t>(ids, ids + count).data());
}

std::string section_name(const std::string& path, int section, int sections) {
  const std::filesystem::path p(path);
  const int digits = std::max<int>(3, static_cast<int>(std::to_string(std::max(sections - 1, 0)).size()));
  return (p.parent_path() /
          fmt::format("{}_{:0{}}{}", p.stem().string(), section, digits, p.extension().string()))
      .string();
}

}  // namespace terrazzo::exporting
