#include "nodes/sizes/load_distribution/read_distribution.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "nodes/common/io/json_input.h"

namespace terrazzo::load_distribution {
namespace {
using Json = nlohmann::json;

constexpr int kMostInt = std::numeric_limits<int>::max();

SizeDistribution::Entry entry_of(const JsonObject& o, std::size_t classes) {
  SizeDistribution::Entry e;
  e.shape = o.whole("shape", -1, kMostInt);
  e.cls = o.whole("class", 0, kMostInt);
  e.N_V = o.numbers("N_V", 0);
  e.low = o.numbers("low", 0);
  e.high = o.numbers("high", 0);
  for (const auto* list : {&e.N_V, &e.low, &e.high})
    if (list->size() != classes)
      o.fail(fmt::format("has {} numbers for {} size classes", list->size(), classes));
  return e;
}

}  // namespace

SizeDistribution read_distribution(const std::string& text, const std::string& file) {
  const JsonSource source{file, "use a .json file that Export wrote from a size distribution"};
  const Json json = parse_json(text, "distribution", source);
  const JsonObject all(json, source, "the distribution ", "bad-distribution");
  SizeDistribution out;
  out.class_edges = all.numbers("class_edges", 0);
  const auto& edges = out.class_edges;
  if (std::adjacent_find(edges.begin(), edges.end(), std::greater_equal<>()) != edges.end())
    all.fail("the field class_edges does not ascend");
  out.volume_fraction = all.number("volume_fraction", 0);
  out.d_max = all.number("d_max", 0);
  out.goodness_of_fit = all.number("goodness_of_fit", 0);
  for (const Json& j : all.list("shapes"))
    out.shapes.push_back(
        entry_of(JsonObject(j, source, fmt::format("entry {}: ", out.shapes.size()), "bad-distribution"),
                 out.classes()));
  return out;
}

}  // namespace terrazzo::load_distribution
