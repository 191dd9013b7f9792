#include "nodes/load_labels/label_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/components.h"
#include "nodes/common/io/picture_input.h"

namespace terrazzo::load_labels {
namespace {

// Reads samples in the file's own type, so that no value is scaled, and checks that each is a whole number.
template <class T>
std::vector<std::uint32_t> read_as(PictureInput& in, const std::filesystem::path& path, Sample type) {
  // The memory estimate covers one integer per sample and one per pixel.
  const auto samples = in.samples<T>(type, 4.0 * in.header().count() + 4);
  std::vector<std::uint32_t> out(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double v = static_cast<double>(samples[i]);
    if (!(v >= 0 && v <= 4294967294.0 && v == std::floor(v)))
      throw Error("bad-labels",
                  "'" + path.string() + "' contains the value " + fmt::format("{:g}", v) +
                      " where a label is expected",
                  "labels must be whole numbers; 0 is the background")
          .parameter("path");
    out[i] = static_cast<std::uint32_t>(v);
  }
  return out;
}

Labels empty_labels(const std::vector<RawMask>& masks, double pixel_size) {
  Labels labels;
  labels.width = masks.at(0).width, labels.height = masks[0].height,
  labels.sections = static_cast<int>(masks.size());
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

RawMask read_mask(const std::filesystem::path& path, const Reading& reading) {
  PictureInput in(path, reading, {{"oiio:UnassociatedAlpha", 1}});
  const PictureHeader s = in.header();
  if (s.deep || s.depth > 1 || s.width <= 0 || s.height <= 0)
    throw in.unreadable("it is not a plain 2D image");
  const bool alpha = s.alpha >= 0 && s.count() > 1;
  const int colors = s.count() - (alpha ? 1 : 0);

  std::vector<std::uint32_t> samples;
  if (s.sample == Sample::UInt8)
    samples = read_as<std::uint8_t>(in, path, s.sample);
  else if (s.sample == Sample::UInt16)
    samples = read_as<std::uint16_t>(in, path, s.sample);
  else if (s.sample == Sample::Int16)
    samples = read_as<std::int16_t>(in, path, s.sample);
  else if (s.sample == Sample::UInt32)
    samples = read_as<std::uint32_t>(in, path, s.sample);
  else if (s.sample == Sample::Int32)
    samples = read_as<std::int32_t>(in, path, s.sample);
  else
    samples = read_as<float>(in, path, Sample::Float);

  RawMask mask{s.width, s.height, {}};
  mask.values.resize(static_cast<std::size_t>(s.width) * s.height);
  for (std::size_t p = 0; p < mask.values.size(); ++p) {
    const std::uint32_t* v = &samples[p * s.count()];
    if (alpha && v[s.alpha] == 0) continue;
    if (colors < 3 || (v[0] == v[1] && v[1] == v[2])) {
      mask.values[p] = v[0];
    } else {
      if (s.sample != Sample::UInt8)
        throw Error("bad-labels", "'" + path.string() + "' has colors of more than 8 bits per channel",
                    "save the mask as gray numbers or as 8-bit colors")
            .parameter("path");
      mask.values[p] = (v[0] << 16 | v[1] << 8 | v[2]) + 1;
    }
  }
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
  const std::size_t plane = static_cast<std::size_t>(labels.width) * labels.height;
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
        ++votes[static_cast<std::size_t>(id) - 1][masks[s].values[p]];
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
