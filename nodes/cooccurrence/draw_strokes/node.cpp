#include <fmt/format.h>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/data/image.h"
#include "nodes/data/strokes.h"
#include "runtime/context.h"

namespace terrazzo::draw_strokes {
namespace {

void check(const NodeParameters& p) {
  for (const auto& text : p.texts("colors")) parse_color(text);
}

void compute(Context& c) {
  Image picture = c.input<Image>("image");
  const Strokes& strokes = c.input<Strokes>("strokes");
  std::vector<Vec3f> colors;
  for (const auto& text : c.texts("colors")) colors.push_back(parse_color(text));
  Image mask(picture.width, picture.height, picture.sections, picture.pixel_size);
  for (std::size_t k = 0; k < strokes.strokes.size(); ++k) {
    check_stroke(strokes.strokes[k]);
    for (const auto p : footprint_of(strokes.strokes[k], picture.width, picture.height))
      for (int s = 0; s < picture.sections; ++s) {
        const std::size_t i = static_cast<std::size_t>(s) * picture.width * picture.height + p;
        picture.pixels[i] = colors[std::min(k, colors.size() - 1)];
        mask.pixels[i] = Vec3f::Ones();
      }
  }
  c.output("mask", std::move(mask));
  c.output("image", std::move(picture));
}

}  // namespace
}  // namespace terrazzo::draw_strokes

namespace terrazzo {

NodeType draw_strokes_node() {
  using namespace draw_strokes;
  return NodeType("DrawStrokes", 1)
      .doc_(
          "Draws strokes on a picture in plain colors and makes a mask of them, to mark a region or to have "
          "something to erase")
      .input("image", "Image", "Picture to draw on")
      .input("strokes", "Strokes", "Strokes, drawn in order")
      .output("image", "Image", "Picture with the strokes on all sections, with hard edges")
      .output("mask", "Image", "White where a stroke is, else black")
      .parameter(Parameter::texts("colors", {"#c02020"})
                     .count(1, 4096)
                     .doc_("Colors of the strokes in turn, \"#rrggbb\" in sRGB. The last one applies to all "
                           "remaining strokes."))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
