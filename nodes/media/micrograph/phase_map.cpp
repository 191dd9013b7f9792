#include "nodes/media/micrograph/phase_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::media {

std::vector<double> fractions_of(const PhaseMap& map) {
  std::vector<double> out(map.phases, 0);
  double observed = 0;
  for (const std::uint8_t p : map.at)
    if (p != kUnobserved) {
      ++out[p];
      ++observed;
    }
  for (double& f : out) f /= std::max(1.0, observed);
  return out;
}

PhaseMap phase_map(const Labels& labels) {
  const int highest =
      labels.classes.empty() ? 0 : *std::max_element(labels.classes.begin(), labels.classes.end()) + 1;
  if (highest >= kMostPhases)
    throw Error("too-many-phases", fmt::format("the labels have {} classes", highest),
                fmt::format("use at most {} phases; with LoadLabels, set kind: classes", kMostPhases));
  PhaseMap out{labels.width, labels.height, highest + 1, labels.pixel_size, {}};
  for (std::size_t i = 0; i < pixels_in(labels.width, labels.height); ++i) {
    const std::int32_t id = labels.ids[i];
    out.at.push_back(id > 0 ? static_cast<std::uint8_t>(labels.classes[id - 1] + 1) : 0);
  }
  return out;
}

PhaseMap cut(const PhaseMap& from, int left, int top, int width, int height) {
  PhaseMap out{width, height, from.phases, from.pixel_size, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) out.at.push_back(from.at[from.index(left + x, top + y)]);
  return out;
}

PhaseMap middle_of(const PhaseMap& map, int side) {
  const int width = std::min(map.width, side), height = std::min(map.height, side);
  return cut(map, (map.width - width) / 2, (map.height - height) / 2, width, height);
}

Labels labels_of(const PhaseMap& map) {
  Labels out;
  out.width = map.width;
  out.height = map.height;
  out.pixel_size = map.pixel_size;
  for (const std::uint8_t p : map.at) out.ids.push_back(p == kUnobserved ? 0 : p);
  for (int p = 1; p < map.phases; ++p) out.classes.push_back(p - 1);
  return out;
}

}  // namespace terrazzo::media
