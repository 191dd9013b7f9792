#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/data/strokes.h"
#include "nodes/texture_nib/nib.h"
#include "nodes/texture_nib/region.h"
#include "nodes/texture_nib/views.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

using namespace texture_nib;

// Where the texture is learnt: the mask, the region, or all that is not painted.
std::vector<std::uint8_t> region_of(Context& c, const Image& picture, const Strokes& strokes,
                                    const std::vector<std::uint8_t>& fill, int reach) {
  const bool written = c.keyword("region").empty();
  if (c.has("region_mask")) {
    if (written)
      throw Error("two-regions", "there is a region_mask, and a region is written", "keep one of them")
          .parameter("region");
    return mask_of(c.value("region_mask"), picture, "region_mask");
  }
  if (written) return region_mask(c.numbers("region"), picture.width, picture.height);
  auto region = region_around(strokes, picture.width, picture.height, reach);
  for (std::size_t i = 0; i < fill.size(); ++i)
    if (fill[i]) region[i] = 0;
  return region;
}

void compute(Context& c) {
  const Image& picture = c.input<Image>("image");
  if (picture.pixels.empty()) throw Error("no-pixels", "the picture has no pixels");
  if (picture.sections > 1)
    throw Error("several-sections", fmt::format("the picture is a stack of {} sections", picture.sections),
                "paint on one at a time");
  if (!c.has("strokes") && !c.has("fill"))
    throw Error("nothing-to-paint", "neither strokes nor fill are connected",
                "connect a Strokes or LoadStrokes node, or a mask");
  Strokes strokes;
  if (const auto* s = c.optional<Strokes>("strokes")) strokes = *s;
  for (std::size_t i = 0; i < strokes.strokes.size(); ++i)
    check_on_picture(strokes.strokes[i], i + 1, picture.width, picture.height);
  std::vector<std::uint8_t> fill;
  if (c.has("fill")) fill = mask_of(c.value("fill"), picture, "fill");

  NibSettings s;
  s.levels = static_cast<int>(c.integer("levels")), s.extent = static_cast<int>(c.integer("extent"));
  s.scales = static_cast<int>(c.integer("scales")), s.space = c.text("space");
  s.seed = static_cast<std::uint64_t>(c.integer("seed"));
  if (c.keyword("threshold").empty()) s.threshold = c.number("threshold");
  NibManner manner;
  manner.passes = static_cast<int>(c.integer("passes")), manner.seed = s.seed;
  const auto finish = c.text("finish");
  manner.finish = finish == "levels" ? Finish::Levels : finish == "colors" ? Finish::Colors : Finish::Patches;

  const auto region = region_of(c, picture, strokes, fill, s.extent);
  Nib nib(picture, learn(picture, region, s, c.work().quiet()), manner);
  const double n = static_cast<double>(strokes.strokes.size()) + 1;
  for (std::size_t i = 0; i < strokes.strokes.size(); ++i)
    nib.paint(strokes.strokes[i], c.work().part(static_cast<double>(i) / n, static_cast<double>(i + 1) / n));
  if (!fill.empty()) nib.paint(pixels_of(fill), c.work().part(1 - 1 / n, 1));

  double painted = 0, relevant = 0;
  for (const auto o : nib.occupancy()) painted += o;
  for (const auto b : nib.base_relative()) relevant += b != kNoLevel;
  c.metric("painted_pixels", painted);
  c.metric("relevant_fraction", relevant / static_cast<double>(nib.base_relative().size()));
  c.metric("threshold", nib.texture().threshold);
  c.metric("error", nib.error());
  c.output("base_relative", base_relative_view(nib));
  c.output("occupancy", occupancy_view(nib));
  c.output("image", nib.picture());
}

}  // namespace

NodeType texture_nib_node() {
  return NodeType("TextureNib", 2)
      .doc_(
          "Paints a region's texture along strokes so that it grows out of what surrounds it; also erases "
          "things from "
          "textured pictures")
      .source_(
          "Malzbender and Spach 1993, section 4; finish patches: completion after Wexler, Shechtman and "
          "Irani "
          "2007 and Barnes et al. 2009")
      .input("image", "Image", "one section")
      .optional_input("strokes", {"Strokes"}, "where the nib goes")
      .optional_input("fill", {"Labels", "Image"},
                      "an area to paint after the strokes: labels other than 0, or brighter than 0.2")
      .optional_input("region_mask", {"Labels", "Image"},
                      "the region whose texture is painted, in the place of the parameter")
      .output("image", "Image", "the picture painted on")
      .output("base_relative", "Image",
              "the picture in the texture's levels, magenta where its colours are none of them")
      .output("occupancy", "Image", "white where the nib has been")
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "region", "rest")
                     .count(4, 4096)
                     .range(-1e6, 1e6)
                     .unit_("pixels")
                     .doc_("Whose texture is painted: x, y, width, height, or a polygon's corners, x and y "
                           "in turn; rest: all "
                           "that is not painted"))
      .parameter(Parameter::integer("levels", 8)
                     .range(2, kMostLevels)
                     .doc_("Colours of the texture, found by k-means"))
      .parameter(Parameter::choice("space", "oklab", {"oklab", "rgb"})
                     .doc_("Where colours are compared: Oklab, or RGB as displays show it (the paper's), "
                           "each from 0 to 1"))
      .parameter(Parameter::integer("extent", 3)
                     .range(1, 16)
                     .unit_("pixels")
                     .doc_("Offsets go up to ± this in x and y: 3 is a kernel of 7 × 7"))
      .parameter(Parameter::integer("scales", 1)
                     .range(1, 8)
                     .doc_("The offsets are also taken 2, 4, … times as long, up to 2^(scales − 1)"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "threshold", "auto")
                     .range(0, 10)
                     .doc_("φ: a pixel whose colour is farther than this from all levels says nothing to the "
                           "nib; in units of "
                           "space. auto: 1.25 times what 99 % of the region keep"))
      .parameter(Parameter::integer("passes", 4)
                     .range(1, 1000)
                     .doc_("How often each pixel of a dab is visited; all once before any a second time"))
      .parameter(Parameter::choice("finish", "patches", {"levels", "colors", "patches"})
                     .doc_("levels: the texture's few colours, the paper's. colors: those of the region's "
                           "pixels of the same "
                           "level in like surroundings. patches: the region's pixels, laid from coarse to "
                           "fine so that every patch looks like one of the region, levels following: shapes "
                           "survive"))
      .parameter(Parameter::integer("seed", 1)
                     .range(0, 9007199254740991)
                     .doc_("Of the order of visits and the search"))
      .compute_(compute);
}

}  // namespace terrazzo
