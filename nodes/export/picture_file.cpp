#include "nodes/export/picture_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/io/checked_file.h"
#include "nodes/common/io/image_file.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::exporting {
namespace {

Error incomplete(std::string why) {
  while (!why.empty() && (why.back() == '\n' || why.back() == ' ')) why.pop_back();
  return Error("write-failed", "the image file is incomplete" + (why.empty() ? "" : ": " + why),
               "check the output folder and the free disk space");
}

// Decodes the whole file to check that it is complete.
void verify(const std::filesystem::path& path) {
  auto in = OIIO::ImageInput::open(path.string());
  if (!in) throw incomplete(OIIO::geterror());
  const auto& spec = in->spec();
  std::vector<unsigned char> pixels(static_cast<std::size_t>(spec.image_bytes()));
  if (!in->read_image(0, 0, 0, spec.nchannels, spec.format, pixels.data())) throw incomplete(in->geterror());
}

}  // namespace

void write_picture(const std::filesystem::path& path, const Image& image, int section,
                   const std::string& provenance) {
  write_image(path, image, section, provenance);
  verify(path);
}

std::string png_of(const Image& image) {
  const std::size_t count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (count == 0 || image.pixels.size() < count) throw Error("empty-image", "the image has no pixels");
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f c = linear_to_srgb(image.pixels[i].cwiseMax(0.0f).cwiseMin(1.0f));
    for (int k = 0; k < 3; ++k) bytes.push_back(static_cast<std::uint8_t>(std::lround(255 * c[k])));
  }
  auto out = OIIO::ImageOutput::create("image.png");
  if (!out) throw incomplete(OIIO::geterror());
  OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  OIIO::Filesystem::IOVecOutput memory;
  if (!out->set_ioproxy(&memory) || !out->open("image.png", spec) ||
      !out->write_image(OIIO::TypeDesc::UINT8, bytes.data()) || !out->close())
    throw incomplete(out->geterror());
  return {reinterpret_cast<const char*>(memory.buffer().data()), memory.buffer().size()};
}

void write_labels(const std::filesystem::path& path, const Labels& labels, int section,
                  const std::string& provenance) {
  const std::size_t count = static_cast<std::size_t>(labels.width) * labels.height;
  if (count == 0 || section < 0 || section >= labels.sections ||
      labels.ids.size() != count * static_cast<std::size_t>(labels.sections))
    throw Error("empty-labels",
                fmt::format("the labels have no section {}: they have {} × {} pixels and {} sections",
                            section, labels.width, labels.height, labels.sections));
  const std::int32_t* ids = labels.ids.data() + count * static_cast<std::size_t>(section);
  const auto [low, high] = std::minmax_element(ids, ids + count);
  if (*low < 0) throw Error("bad-labels", fmt::format("label ids must not be negative; one is {}", *low));
  const bool png = path.extension() == ".png";
  if (png && *high > 65535)
    throw Error("too-many-labels", fmt::format("id {} does not fit the 16 bits of a .png", *high),
                "use .tif or .exr");

  auto out = OIIO::ImageOutput::create(path.string());
  if (!out) throw incomplete(OIIO::geterror());
  OIIO::ImageSpec spec(labels.width, labels.height, 1, png ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT32);
  spec.attribute("oiio:ColorSpace", "Raw");  // no gamma chunk: these are ids, not intensities
  if (!png) spec.attribute("compression", "zip");
  if (!provenance.empty()) spec.attribute("ImageDescription", provenance);
  OIIO::Filesystem::IOVecOutput memory;  // as in write_image
  const bool in_memory = path.extension() != ".tif" && out->supports("ioproxy") && out->set_ioproxy(&memory);
  if (!out->open(path.string(), spec)) throw incomplete(out->geterror());
  bool written = false;
  if (png) {
    const std::vector<std::uint16_t> narrow(ids, ids + count);
    written = out->write_image(OIIO::TypeDesc::UINT16, narrow.data());
  } else {
    const std::vector<std::uint32_t> wide(ids, ids + count);
    written = out->write_image(OIIO::TypeDesc::UINT32, wide.data());
  }
  if (!written || !out->close()) throw incomplete(out->geterror());
  if (in_memory)
    write_bytes(path, {reinterpret_cast<const char*>(memory.buffer().data()), memory.buffer().size()});
  verify(path);
}

std::string section_name(const std::string& path, int section, int sections) {
  const std::filesystem::path p(path);
  const int digits = std::max<int>(3, static_cast<int>(std::to_string(std::max(sections - 1, 0)).size()));
  return (p.parent_path() /
          fmt::format("{}_{:0{}}{}", p.stem().string(), section, digits, p.extension().string()))
      .string();
}

}  // namespace terrazzo::exporting
