#include "nodes/photograph/load_labels/label_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/components.h"
#include "nodes/common/io/pictures/stored_picture.h"
#include "nodes/data/indices.h"

namespace terrazzo::load_labels {
namespace {

constexpr double kLargestLabel = 4294967294.0;

Error bad_mask(const std::filesystem::path& path, const std::string& what, const std::string& hint) {
  return Error("bad-labels", fmt::format("'{}' {}", path.string(), what), hint).parameter("path");
}

std::uint32_t label_of(double v, const std::filesystem::path& path) {
  if (!(v >= 0 && v <= kLargestLabel && v == std::floor(v)))
    throw bad_mask(
        path, fmt::format("contains the value {:.17g} where a label is expected", v),
        fmt::format("labels must be whole numbers up to {:.0f}; 0 is the background", kLargestLabel));
  return static_cast<std::uint32_t>(v);
}

// The label of a pixel of a picture with colors.
std::uint32_t color_label(const StoredSamples& s, std::size_t pixel, const std::filesystem::path& path) {
  std::uint32_t rgb[3];
  for (int k = 0; k < 3; ++k) rgb[k] = label_of(s.at(pixel, k), path);
  if (rgb[0] == rgb[1] && rgb[1] == rgb[2]) return rgb[0];
  if (s.bits > 8 || s.is_float)
    throw bad_mask(path, "has colors of more than 8 bits per channel",
                   "save the mask as gray numbers or as 8-bit colors");
  return (rgb[0] << 16 | rgb[1] << 8 | rgb[2]) + 1;
}

// What the user may not expect about the background.
void warn_of_background(const StoredSamples& s, const std::string& name, const Reading& reading) {
  const auto black = std::array<std::uint8_t, 3>{0, 0, 0};
  if (!s.palette.empty() && s.palette[0] != black &&
      std::find(s.palette.begin(), s.palette.end(), black) != s.palette.end())
    reading.warn(
        fmt::format("'{}': color 0 of the palette is the background, but it is not black; to use colors as "
                    "labels, save the mask as RGB",
                    name));
  if (s.white_is_zero)
    reading.warn(
        fmt::format("'{}' is stored as WhiteIsZero: what viewers show as white has the number 0 and is the "
                    "background; to swap both, invert the mask",
                    name));
}

// Whether the pixels around (x, y) have two labels other than its own.
bool touches_two(const RawMask& m, int x, int y) {
  const std::uint32_t own = m.at(x, y);
  std::uint32_t other = own;
  for (int v = std::max(0, y - 1); v <= std::min(m.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(m.width - 1, x + 1); ++u) {
      const std::uint32_t label = m.at(u, v);
      if (label == own || label == other) continue;
      if (other != own) return true;
      other = label;
    }
  return false;
}

// Masks that were smoothed, resampled or compressed with losses have values along their borders that occur
// nowhere else. Each of their pixels touches two others; a label has pixels inside, or touches only
// background.
void require_unmixed(const RawMask& m, const std::filesystem::path& path) {
  std::map<std::uint32_t, bool> mixed;  // by label: all of its pixels touch two others
  for (const auto v : m.values)
    if (v != 0) mixed.emplace(v, true);
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x)
      if (const auto label = mixed.find(m.at(x, y)); label != mixed.end() && label->second)
        label->second = touches_two(m, x, y);
  const std::size_t count =
      std::count_if(mixed.begin(), mixed.end(), [](const auto& label) { return label.second; });
  constexpr std::size_t kLeast = 3;  // of two by two samples per pixel
  if (count < kLeast || count == mixed.size() || 2 * count <= mixed.size()) return;
  throw Error(
      "blurred-mask",
      fmt::format(
          "{} of the {} values of '{}' occur only where others meet: the mask was smoothed, resampled or "
          "compressed with losses",
          count, mixed.size(), path.string()),
      "save the mask without antialiasing, and resize it with the nearest neighbor; or apply a threshold")
      .parameter("path");
}

// Whether the pixel and all around it have the same label.
bool is_inside(const RawMask& m, int x, int y) {
  if (x < 1 || y < 1 || x + 1 >= m.width || y + 1 >= m.height) return false;
  for (int v = y - 1; v <= y + 1; ++v)
    for (int u = x - 1; u <= x + 1; ++u)
      if (m.at(u, v) != m.at(x, y)) return false;
  return true;
}

// Noise of a lossy compression makes classes of scattered pixels. A class has some pixel whose neighbors
// belong to it too, unless all of its profiles are tiny; most classes of a mask are not like that.
void require_solid(const std::vector<RawMask>& masks, const std::set<std::uint32_t>& classes) {
  std::set<std::uint32_t> solid;
  for (const auto& m : masks)
    for (int y = 0; y < m.height; ++y)
      for (int x = 0; x < m.width; ++x)
        if (m.at(x, y) != 0 && is_inside(m, x, y)) solid.insert(m.at(x, y));
  const std::size_t scattered = classes.size() - solid.size();
  constexpr std::size_t kLeast = 3;
  if (scattered < kLeast || solid.empty() || 2 * scattered <= classes.size()) return;
  throw Error(
      "blurred-mask",
      fmt::format(
          "{} of the {} classes have only scattered pixels, as if the mask had been compressed with losses",
          scattered, classes.size()),
      "save the mask as PNG or TIFF in the program that made it; or apply a threshold")
      .parameter("path");
}

Labels empty_labels(const std::vector<RawMask>& masks, double pixel_size) {
  Labels labels;
  labels.width = masks.at(0).width;
  labels.height = masks[0].height;
  labels.sections = masks.size();
  labels.pixel_size = pixel_size;
  for (const auto& m : masks)
    if (m.width != labels.width || m.height != labels.height)
      throw Error("size-mismatch",
                  "the masks of one stack are " + std::to_string(m.width) + " × " + std::to_string(m.height) +
                      " and " + std::to_string(labels.width) + " × " + std::to_string(labels.height) +
                      " pixels",
                  "all sections of a stack must have the same size and scale")
          .parameter("path");
  labels.ids.reserve(masks.size() * labels.width * labels.height);
  return labels;
}

Labels with_any(Labels labels) {
  if (labels.classes.empty())
    throw Error("no-particles", "the mask is all background",
                "use a mask with values other than 0 and black, which are background")
        .parameter("path");
  return labels;
}

}  // namespace

RawMask read_mask(const std::filesystem::path& path, const PageOptions& choice, const Reading& reading) {
  const PictureContent content = checked_picture(path, reading);
  const ChosenPage chosen = choose_page(content.pages, choice, path);
  const StoredSamples s = stored_samples(content, chosen.page, reading, 3.0 * sizeof(std::uint32_t));
  const std::string name = printable(path.filename().string());
  if (s.is_lossy)
    throw Error(
        "lossy-mask",
        fmt::format("'{}' is compressed with losses (JPEG), which changes the numbers of a mask",
                    path.string()),
        "save the mask as PNG or TIFF in the program that made it; if there is only this file, threshold it "
        "into black and white first")
        .parameter("path");
  if (chosen.channel && *chosen.channel >= s.count)
    throw Error("bad-value",
                fmt::format("channel is {}, but '{}' has {} channels per pixel", *chosen.channel + 1,
                            path.string(), s.count),
                "channels are counted from 1")
        .parameter("channel");
  if (!chosen.channel && !s.is_color && s.plain() != 1)
    throw Error("several-channels",
                fmt::format("'{}' has {} channels per pixel, which are no colors", path.string(), s.plain()),
                fmt::format("set channel to the one to read, from 1 to {}", s.count))
        .parameter("channel");
  warn_of_background(s, name, reading);
  const bool colors = s.is_color && !chosen.channel;
  RawMask mask{s.width, s.height, {}};
  mask.values.resize(pixels_in(s.width, s.height));
  for (std::size_t p = 0; p < mask.values.size(); ++p) {
    if (!chosen.channel && s.alpha >= 0 && s.at(p, s.alpha) == 0) continue;
    const double v = s.at(p, chosen.channel.value_or(0));
    if (s.clear && v == *s.clear) continue;
    if (!s.palette_alpha.empty() && v < s.palette_alpha.size() && s.palette_alpha[v] == 0) continue;
    mask.values[p] = colors ? color_label(s, p, path) : label_of(v, path);
  }
  require_unmixed(mask, path);
  return mask;
}

Labels labels_from_instances(const std::vector<RawMask>& masks, double pixel_size) {
  Labels labels = empty_labels(masks, pixel_size);
  for (const auto& m : masks) {
    std::map<std::uint32_t, std::int32_t> id;
    for (const auto v : m.values)
      if (v != 0) id.emplace(v, 0);
    for (auto& [value, number] : id) {
      labels.classes.push_back(0);
      number = labels.count();
    }
    for (const auto v : m.values) labels.ids.push_back(v == 0 ? 0 : id.at(v));
  }
  return with_any(std::move(labels));
}

Labels labels_from_classes(const std::vector<RawMask>& masks, double pixel_size) {
  Labels labels = empty_labels(masks, pixel_size);
  std::set<std::uint32_t> values;
  for (const auto& m : masks) values.insert(m.values.begin(), m.values.end());
  values.erase(0);
  if (values.size() > 64)
    throw Error("too-many-classes", "the mask contains " + std::to_string(values.size()) + " classes",
                "set kind: instances, or save the mask without antialiasing and without JPEG compression")
        .parameter("kind");
  require_solid(masks, values);
  for (const auto& m : masks) {
    std::vector<std::int32_t> raster(m.values.size());
    for (std::size_t p = 0; p < raster.size(); ++p)
      raster[p] =
          m.values[p] == 0
              ? 0
              : 1 + static_cast<std::int32_t>(std::distance(values.begin(), values.find(m.values[p])));
    const Components parts = connected_components(raster, m.width, m.height, true);
    const int before = labels.count();
    for (const auto id : parts.ids) labels.ids.push_back(id == 0 ? 0 : id + before);
    for (const auto v : parts.values) labels.classes.push_back(v - 1);
  }
  return with_any(std::move(labels));
}

void set_classes(Labels& labels, const std::vector<RawMask>& masks) {
  constexpr std::uint32_t kHighest = 1'000'000;
  const auto wrong = [](const char* code, const std::string& what, const std::string& hint) {
    return Error(code, what, hint).parameter("classes");
  };
  const std::size_t plane = pixels_in(labels.width, labels.height);
  if (masks.size() != static_cast<std::size_t>(labels.sections))
    throw wrong("size-mismatch",
                fmt::format("there are {} masks of classes for {} sections", masks.size(), labels.sections),
                "write one for each section");
  std::vector<std::map<std::uint32_t, std::size_t>> votes(labels.classes.size());
  for (std::size_t s = 0; s < masks.size(); ++s) {
    if (masks[s].width != labels.width || masks[s].height != labels.height)
      throw wrong("size-mismatch",
                  fmt::format("a mask of classes is {} × {} pixels, but the labels are {} × {}",
                              masks[s].width, masks[s].height, labels.width, labels.height),
                  "both must show the same section");
    for (std::size_t p = 0; p < plane; ++p)
      if (const auto id = labels.ids[s * plane + p]; id > 0 && masks[s].values[p] > 0)
        ++votes[id - 1][masks[s].values[p]];
  }
  for (std::size_t k = 0; k < votes.size(); ++k) {
    if (votes[k].empty())
      throw wrong("bad-labels", fmt::format("profile {} has no class: the mask of classes is 0 there", k + 1),
                  "classes are numbered from 1; 0 is background");
    const auto most = std::max_element(votes[k].begin(), votes[k].end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most->first > kHighest)
      throw wrong("bad-labels", fmt::format("the mask of classes contains {}", most->first),
                  "number the classes from 1 to 1,000,000");
    labels.classes[k] = static_cast<std::int32_t>(most->first) - 1;
  }
}

}  // namespace terrazzo::load_labels
