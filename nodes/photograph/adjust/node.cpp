#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/photograph/adjust/adjust.h"
#include "runtime/context.h"

namespace terrazzo::adjust {
namespace {

constexpr double kLeastContrast = 0.001;

void check(const NodeParameters& p) {
  if (p.number("white") - p.number("black") < kLeastContrast)
    throw Error("bad-range",
                fmt::format("white must be at least {} above black ({}); it is {}", kLeastContrast,
                            p.number("black"), p.number("white")),
                "raise white, or lower black")
        .parameter("white");
  if (p.keyword("crop").empty() && (p.ints("crop")[2] < 1 || p.ints("crop")[3] < 1))
    throw Error("bad-region", "a crop is at least 1 pixel wide and high", "give left, top, width and height")
        .parameter("crop");
}

void compute(Context& c) {
  AdjustOptions o{
      {}, c.number("black"), c.number("white"), c.number("gamma"), c.number("hue"), c.number("saturation")};
  if (c.keyword("crop").empty()) {
    const auto& part = c.ints("crop");
    o.crop.emplace();
    std::copy_n(part.begin(), 4, o.crop->begin());
  }
  c.output("image", adjust_image(c.input<Image>("image"), o, c.work()));
}

}  // namespace
}  // namespace terrazzo::adjust

namespace terrazzo {

NodeType adjust_node() {
  using namespace adjust;
  return NodeType("Adjust", 1)
      .doc_("Crops a picture, and changes its levels, hue and saturation")
      .source_("W3C Filter Effects Module Level 1, feColorMatrix")
      .input("image", "Image", "Picture to change")
      .output("image", "Image", "Changed picture")
      .parameter(Parameter::with_keyword(ParameterKind::Ints, "crop", "none")
                     .count(4, 4)
                     .range(0, 1000000)
                     .unit_("pixels")
                     .doc_("Part to keep: left, top, width, height"))
      .parameter(Parameter::number("black", 0)
                     .range(0, 1)
                     .doc_("Brightness that becomes black, as displayed (sRGB)"))
      .parameter(Parameter::number("white", 1)
                     .range(0, 1)
                     .doc_("Brightness that becomes white. What is brighter stays brighter."))
      .parameter(Parameter::number("gamma", 1)
                     .range(0.1, 10)
                     .doc_("Curve between black and white. Above 1: lighter. Below 1: darker."))
      .parameter(Parameter::number("hue", 0).range(-360, 360).unit_("degrees").doc_(
          "Turns hues. The luminance stays."))
      .parameter(Parameter::number("saturation", 1)
                     .range(0, 10)
                     .doc_("Multiplies the distance from gray. 0: gray. The luminance stays."))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
