#include "nodes/common/io/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/color_config.h"
#include "nodes/common/io/pictures/color_profile.h"
#include "nodes/common/io/pictures/georeferences.h"
#include "nodes/common/io/pictures/orientation.h"
#include "nodes/common/io/pictures/picture_input.h"
#include "nodes/common/io/pictures/stored_picture.h"
#include "nodes/common/texture/color.h"

namespace terrazzo {
namespace {

// The samples that become red, green and blue, and alpha; alpha is −1 if there is none.
struct Channels {
  int rgb[3] = {0, 0, 0};
  int alpha = -1;
  bool is_gray() const { return rgb[0] == rgb[1] && rgb[1] == rgb[2]; }
};

// A picture before its colors are converted.
struct Encoded {
  Image image;
  std::vector<float> alpha;
  bool premultiplied = false;
  bool is_float = false;
  float top = 0;  // the encoded values are multiples of 1 / top; 0: they are not
  bool is_gray = false;
};

Error several_channels(const std::filesystem::path& path, int count, const std::string& names) {
  return Error("several-channels",
               fmt::format("'{}' has {} channels per pixel{}, which are not red, green and blue",
                           path.string(), count, names),
               fmt::format("set channel to the one to read, from 1 to {}", count))
      .parameter("channel");
}

Channels one_channel(int channel, int count, const std::filesystem::path& path) {
  if (channel < 0 || channel >= count)
    throw Error(
        "bad-value",
        fmt::format("channel is {}, but '{}' has {} channels per pixel", channel + 1, path.string(), count),
        "channels are counted from 1")
        .parameter("channel");
  return {{channel, channel, channel}, -1};
}

// Channels of a TIFF file, or of a palette, as the file describes them.
Channels channels_of_stored(const StoredSamples& s, const std::filesystem::path& path) {
  if (s.is_color) return {{0, 1, 2}, s.alpha};
  if (s.plain() > 1) throw several_channels(path, s.plain(), "");
  return {{0, 0, 0}, s.alpha};
}

Channels channels_by_name(const PictureHeader& h, const std::filesystem::path& path) {
  Channels c;
  c.alpha = h.alpha >= 0 && h.alpha < h.count() && h.count() > 1 ? h.alpha : -1;
  int found[3] = {-1, -1, -1};
  for (int i = 0; i < h.count(); ++i)
    for (int k = 0; k < 3; ++k)
      if (h.channels[i] == std::string(1, "RGB"[k])) found[k] = i;
  if (found[0] >= 0 && found[1] >= 0 && found[2] >= 0) {
    std::copy(found, found + 3, c.rgb);
    return c;
  }
  const int colors = h.count() - (c.alpha >= 0 ? 1 : 0);
  if (colors != 1 && colors != 3) {
    std::string names;
    for (const auto& n : h.channels) names += (names.empty() ? " (" : ", ") + printable(n);
    throw several_channels(path, h.count(), names + ")");
  }
  for (int k = 0; k < 3; ++k) c.rgb[k] = colors == 3 ? k : 0;
  return c;
}

void require_known_colors(const StoredSamples& s, const std::filesystem::path& path) {
  if (s.kind == ColorKind::Ink)
    throw unsupported_picture(path, "is a CMYK picture, whose colors are amounts of ink",
                              "convert it to RGB with its color profile, in the program that made it");
  if (s.kind == ColorKind::Lab)
    throw unsupported_picture(path, "stores its colors as CIE Lab",
                              "convert it to RGB, in the program that made it");
}

// Whole numbers up to `top` become values up to 1.
template <class T>
void take_samples(const std::vector<T>& samples, int count, const Channels& c, float top, Encoded& out) {
  const std::size_t stride = count;
  for (std::size_t p = 0; p < out.image.pixels.size(); ++p)
    for (int k = 0; k < 3; ++k)
      out.image.pixels[p][k] = static_cast<float>(samples[p * stride + c.rgb[k]]) / top;
  if (c.alpha < 0) return;
  out.alpha.resize(out.image.pixels.size());
  for (std::size_t p = 0; p < out.alpha.size(); ++p)
    out.alpha[p] = static_cast<float>(samples[p * stride + c.alpha]) * (1 / top);
}

// The image, its upright copy, and alpha.
constexpr double kMore = 2 * sizeof(Vec3f) + sizeof(float);

Encoded read_decoded(PictureInput& in, const Channels& channels, double pixel_size) {
  const PictureHeader h = in.header();
  Encoded out;
  out.is_float = h.is_float;
  out.is_gray = channels.is_gray();
  out.premultiplied = in.attributes().whole("oiio:UnassociatedAlpha", 0) == 0;
  const auto room = [&] { out.image = Image(h.width, h.height, 1, pixel_size); };
  if (h.sample == Sample::UInt8) {
    const auto samples = in.samples<std::uint8_t>(Sample::UInt8, kMore);
    room();
    take_samples(samples, h.count(), channels, out.top = 255, out);
  } else if (!h.is_float) {
    const auto samples = in.samples<std::uint16_t>(Sample::UInt16, kMore);
    room();
    take_samples(samples, h.count(), channels, out.top = 65535, out);
  } else {
    const auto samples = in.samples<float>(Sample::Float, kMore);
    room();
    take_samples(samples, h.count(), channels, 1, out);
  }
  return out;
}

// Pages that OpenImageIO cannot reach, and GIF files.
Encoded read_stored(const PictureContent& content, const ChosenPage& chosen, double pixel_size,
                    const Reading& reading) {
  StoredSamples s = stored_samples(content, chosen.page, reading, kMore);
  require_known_colors(s, content.path);
  Encoded out;
  out.is_float = s.is_float;
  out.image = Image(s.width, s.height, 1, pixel_size);
  if (!s.palette.empty()) {
    for (std::size_t p = 0; p < s.values.size(); ++p) {
      const auto index = std::min<std::size_t>(s.values[p], s.palette.size() - 1);
      for (std::size_t k = 0; k < 3; ++k)
        out.image.pixels[p][static_cast<int>(k)] = s.palette[index][k] / 255.0f;
      out.alpha.push_back(index < s.palette_alpha.size() ? s.palette_alpha[index] / 255.0f : 1);
    }
    return out;
  }
  const double top = s.is_float ? 1 : std::ldexp(1.0, std::min(s.bits, 53)) - 1;
  if (s.white_is_zero)
    for (double& v : s.values) v = top - v;
  const Channels channels = chosen.channel ? one_channel(*chosen.channel, s.count, content.path)
                                           : channels_of_stored(s, content.path);
  out.is_gray = channels.is_gray();
  take_samples(s.values, s.count, channels, top, out);
  return out;
}

void require_finite(const Encoded& e, const std::filesystem::path& path) {
  if (!e.is_float) return;
  for (std::size_t p = 0; p < e.image.pixels.size(); ++p)
    if (!e.image.pixels[p].allFinite()) {
      const std::size_t width = e.image.width;
      throw Error("bad-pixels",
                  fmt::format("'{}' contains NaN or infinity at column {}, row {}", path.string(), p % width,
                              p / width),
                  "replace those pixels before reading the image")
          .parameter("path");
    }
}

// What the file states about its color space; none: nothing.
std::optional<ColorProfile> profile_of(const PictureMetadata& m, const std::string& icc, const Encoded& e,
                                       const std::filesystem::path& path) try {
  if (!m.unknown_encoding.empty())
    throw Error("bad-color-profile",
                m.unknown_encoding + ", which is no encoding of photographs that is supported",
                "convert the picture to sRGB, or set colorspace");
  std::optional<ColorProfile> profile;
  if (!icc.empty() && !m.overrides_profile)
    profile.emplace(icc);
  else if (m.colors)
    profile.emplace(*m.colors);
  if (profile && profile->is_gray() && !e.is_gray)
    throw Error("bad-color-profile",
                "the embedded color profile is for gray pictures, but the picture has colors",
                "set colorspace to the color space of the picture, such as sRGB");
  return profile;
} catch (const Error& error) {
  throw Error("bad-color-profile", fmt::format("'{}': {}", path.string(), error.diagnostic().message),
              error.diagnostic().hint)
      .parameter("colorspace");
}

// Converts through a table where it can, which is as fast as a copy.
void decode_srgb(Encoded& e) {
  if (e.top == 0) {
    for (auto& p : e.image.pixels) p = srgb_to_linear(p);
    return;
  }
  std::vector<float> table(e.top + 1);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = srgb_to_linear(Vec3f::Constant(i / e.top))[0];
  for (auto& p : e.image.pixels)
    for (int k = 0; k < 3; ++k) p[k] = table[static_cast<std::size_t>(p[k] * e.top + 0.5f)];
}

// Makes the colors scene-linear Rec. 709.
void convert_colors(Encoded& e, const std::string& colorspace, const PictureMetadata& metadata,
                    const std::string& icc, const std::filesystem::path& path) {
  Image& image = e.image;
  const std::size_t width = image.width, height = image.height;
  if (colorspace != "auto") return to_linear_rec709(image.pixels.data(), width, height, colorspace);
  const char* environment = std::getenv("OCIO");
  // Scene-linear as defined by that configuration.
  const bool own_linear = e.is_float && environment && *environment;
  const auto profile = own_linear && icc.empty() ? std::nullopt : profile_of(metadata, icc, e, path);
  if (profile && !profile->is_srgb()) {
    if (!profile->is_linear()) profile->to_linear(image.pixels.data(), image.pixels.size());
  } else if (profile || !e.is_float) {
    decode_srgb(e);
  } else if (own_linear) {
    to_linear_rec709(image.pixels.data(), width, height, "scene_linear");
  }
}

// Puts the picture over black.
void composite(Encoded& e, const std::filesystem::path& path, const Reading& reading) {
  if (const auto clear = std::count(e.alpha.begin(), e.alpha.end(), 0.0f); clear > 0)
    reading.warn(
        fmt::format("'{}': {} % of the pixels are transparent and become black; cut them off, or tell "
                    "Segment to ignore them",
                    printable(path.filename().string()),
                    std::max<std::int64_t>(1, 100 * clear / static_cast<std::int64_t>(e.alpha.size()))));
  if (e.premultiplied) return;
  for (std::size_t p = 0; p < e.alpha.size(); ++p) e.image.pixels[p] *= e.alpha[p];
}

}  // namespace

Image read_image(const std::filesystem::path& path, const std::string& colorspace, double pixel_size,
                 const Reading& reading, StatedSizes* sizes, const PageOptions& choice) {
  PictureContent content = checked_picture(path, reading);
  const ChosenPage chosen = choose_page(content.pages, choice, path);
  const PictureMetadata metadata = metadata_of(content, chosen.page);
  if (sizes) sizes->place = place_in_tiff(content, chosen.page);
  if (sizes) sizes->turned = is_turned(metadata.orientation);
  if (chosen.page.number < 0 || content.format == "gif") {
    Encoded e = read_stored(content, chosen, pixel_size, reading);  // upright
    require_finite(e, path);
    convert_colors(e, colorspace, metadata, "", path);
    composite(e, path, reading);
    return std::move(e.image);
  }
  std::optional<StoredSamples> described;
  if (content.format == "tiff") described = tiff_description(content, chosen.page);
  if (described) require_known_colors(*described, path);
  const std::uint64_t size = content.bytes.size();
  std::string().swap(content.bytes);
  // Otherwise the decoder multiplies encoded values by alpha.
  PictureInput in(std::move(content), size, reading, {{"oiio:UnassociatedAlpha", 1}});
  if (!in.seek(chosen.page.number)) throw in.unreadable("it has no such page");
  if (in.header().deep) throw in.unreadable("deep images have no single color per pixel");
  if (sizes) sizes->pixel = pixel_scale_of(in.attributes());
  if (sizes) sizes->field_of_view = field_of_view_of(in.attributes());
  const bool as_described =
      described && described->kind == ColorKind::Plain && described->count == in.header().count();
  const Channels channels = chosen.channel ? one_channel(*chosen.channel, in.header().count(), path)
                            : as_described ? channels_of_stored(*described, path)
                                           : channels_by_name(in.header(), path);
  const std::string icc = in.attributes().bytes("ICCProfile");
  Encoded e = read_decoded(in, channels, pixel_size);
  require_finite(e, path);
  convert_colors(e, colorspace, metadata, icc, path);
  composite(e, path, reading);
  // OpenImageIO reads the EXIF data of fewer formats, but knows other sources.
  const int known = in.attributes().whole("Orientation", 1);
  const int orientation = known != 1 ? known : metadata.orientation;
  if (sizes) sizes->turned = is_turned(orientation);
  make_upright(e.image.pixels, e.image.width, e.image.height, 1, orientation);
  return std::move(e.image);
}

}  // namespace terrazzo
