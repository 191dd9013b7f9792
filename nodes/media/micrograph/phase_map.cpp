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

std::vector<PhaseMap> phase_maps(const Labels& labels) {
  const int highest =
      labels.classes.empty() ? 0 : *std::max_element(labels.classes.begin(), labels.classes.end()) + 1;
  if (highest >= kMostPhases)
    throw Error("too-many-phases", fmt::format("the labels have {} classes", highest),
                fmt::format("use at most {} phases; with LoadLabels, set kind: classes", kMostPhases));
  std::vector<PhaseMap> out;
  const std::size_t pixels = pixels_in(labels.width, labels.height);
  for (int s = 0; s < labels.sections; ++s) {
    PhaseMap map{labels.width, labels.height, highest + 1, labels.pixel_size, {}};
    map.at.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::int32_t id = labels.ids[s * pixels + i];
      map.at[i] = id > 0 ? static_cast<std::uint8_t>(labels.classes[id - 1] + 1) : 0;
    }
    const auto shares = fractions_of(map);
    if (std::count_if(shares.begin(), shares.end(), [](double f) { return f > 0; }) < 2)
      throw Error("one-phase", fmt::format("section {} of the labels shows a single phase", s + 1),
                  "use a picture that shows at least two");
    out.push_back(std::move(map));
  }
  return out;
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
