#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "nodes/common/io/text_input.h"
#include "nodes/photograph/load_ebsd/grains.h"
#include "runtime/context.h"

namespace terrazzo::load_ebsd {
namespace {

enum class Picture { Orientation, Quality };

EbsdMap read_map(Context& c) {
  const auto files = c.files("path");
  if (files.size() != 1)
    throw Error("bad-value", fmt::format("path names {} files; a map is one file", files.size()),
                "use one node per map, for example with each")
        .parameter("path");
  try {
    const std::string text = read_text(files[0], reading_of(c)), file = files[0].string();
    const double bytes = kMapBytesPerByte * text.size();
    require_memory(bytes, c.memory(), fmt::format("the map '{}'", file));
    const std::uint64_t left = c.memory() - bytes;
    return text.starts_with("Channel Text File") ? read_ctf(text, file, left) : read_ang(text, file, left);
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

void compute(Context& c) {
  const EbsdMap map = read_map(c);
  // Labels, sets and pictures of the grains.
  require_memory(static_cast<double>(map.points.size()) * 60, c.memory(), "the grains of the map");
  GrainRule rule;
  rule.misorientation = c.number("misorientation");
  rule.min_confidence = c.number("min_confidence");
  rule.max_deviation = c.number("max_deviation");
  rule.min_pixels = c.integer("min_pixels");
  rule.fill = c.integer("fill");
  if (c.keyword("phases").empty()) rule.phases = c.ints("phases");
  Grains grains = find_grains(map, rule, c.work());
  c.output("image", c.choice<Picture>("picture") == Picture::Orientation ? orientation_image(map, c.work())
                                                                         : quality_image(map));
  c.output("table", grain_table(map, grains));
  const auto indexed =
      std::count_if(map.points.begin(), map.points.end(), [](const MapPoint& p) { return p.phase >= 0; });
  const auto labeled = std::count_if(grains.labels.ids.begin(), grains.labels.ids.end(),
                                     [](std::int32_t id) { return id > 0; });
  if (map.missing > 0)
    c.warn(fmt::format("the file has no point for {} places of its grid; they count as not indexed",
                       map.missing));
  const auto share = [&](auto count) { return static_cast<double>(count) / map.points.size(); };
  if (share(indexed) < 0.5)
    c.warn(fmt::format("only {:.0f} % of the map's points are indexed", 100 * share(indexed)));
  c.metric("grains", grains.grains.size());
  c.metric("phases", map.phases.size());
  c.metric("indexed", share(indexed));
  c.metric("area_fraction", share(labeled));
  c.output("labels", std::move(grains.labels));
}

}  // namespace
}  // namespace terrazzo::load_ebsd

namespace terrazzo {

NodeType load_ebsd_node() {
  using namespace load_ebsd;
  return NodeType("LoadEBSD", 2)
      .doc_(
          "Reads an EBSD map and finds its grains: regions in which the orientation of the crystal changes "
          "little.")
      .output("labels", "Labels",
              "Grains. Points outside all grains are 0. Classes are the phases of the map, from 0.")
      .output("image", "Image", "The map as a picture of equal size, for Segment")
      .output("table", "Table",
              "One row per grain: phase, size, mean orientation (Bunge's Euler angles), spread, quality")
      .parameter(
          Parameter::input_path("path").doc_("Map of EDAX/TSL (.ang) or Oxford/HKL (.ctf). Lengths are "
                                             "in micrometers unless the header says otherwise."))
      .parameter(Parameter::number("misorientation", 10)
                     .unit_("degrees")
                     .range(0.5, 60)
                     .doc_("Neighbors that differ by less belong to one grain. Symmetry of the crystal is "
                           "taken into account."))
      .parameter(Parameter::number("min_confidence", -1)
                     .range(-1, 1)
                     .doc_("Points with a lower confidence index belong to no grain (.ang). 0.1 is usual."))
      .parameter(
          Parameter::number("max_deviation", 180)
              .unit_("degrees")
              .range(0, 180)
              .doc_("Points with a larger mean angular deviation belong to no grain (.ctf). 1.5 is usual."))
      .parameter(Parameter::integer("min_pixels", 1)
                     .unit_("pixels")
                     .range(1, 1'000'000)
                     .doc_("Smaller grains are removed"))
      .parameter(Parameter::integer("fill", 0).unit_("pixels").range(0, 1000).doc_(
          "Points that belong to no grain join a grain at most this far away. 0: they stay binder."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Ints, "phases", "all")
              .range(1, 1000)
              .count(1, 1000)
              .doc_("Phases whose grains are particles, by their order in the file from 1; the others are "
                    "binder"))
      .parameter(
          Parameter::choice("picture", "orientation", {"orientation", "quality"})
              .doc_("orientation: color of the crystal direction normal to the map, equal for equivalent "
                    "orientations. quality: image quality or band contrast as gray."))
      .compute_(compute);
}

}  // namespace terrazzo
