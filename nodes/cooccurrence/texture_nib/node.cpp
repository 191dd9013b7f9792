#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/cooccurrence/texture_nib/nib.h"
#include "nodes/cooccurrence/texture_nib/region.h"
#include "nodes/cooccurrence/texture_nib/views.h"
#include "nodes/data/strokes.h"
#include "runtime/context.h"

namespace terrazzo::texture_nib {
namespace {

// The region whose texture is learned: the mask, the parameter, or all pixels not painted.
std::vector<std::uint8_t> region_of(Context& c, const Image& picture, const Strokes& strokes,
                                    const std::vector<std::uint8_t>& fill, int reach) {
  const bool written = c.keyword("region").empty();
  if (c.has("region_mask")) {
    if (written)
      throw Error("two-regions", "both region_mask and region are set", "keep only one of them")
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
    throw Error("several-sections", fmt::format("the picture has {} sections", picture.sections),
                "select a single section");
  if (!c.has("strokes") && !c.has("fill"))
    throw Error("nothing-to-paint", "neither strokes nor fill is connected",
                "connect a Strokes or LoadStrokes node, or a mask");
  Strokes strokes;
  if (const auto* s = c.optional<Strokes>("strokes")) strokes = *s;
  for (std::size_t i = 0; i < strokes.strokes.size(); ++i)
    check_on_picture(strokes.strokes[i], i + 1, picture.width, picture.height);
  std::vector<std::uint8_t> fill;
  if (c.has("fill")) fill = mask_of(c.value("fill"), picture, "fill");

  NibOptions s;
  s.levels = c.integer("levels");
  s.extent = c.integer("extent");
  s.scales = c.integer("scales");
  s.space = c.choice<ColorSpace>("space");
  s.seed = c.seed();
  if (const auto v = c.optional_number("threshold")) s.threshold = *v;
  DabOptions dab_settings;
  dab_settings.passes = c.integer("passes");
  dab_settings.seed = s.seed;
  dab_settings.finish = c.choice<Finish>("finish");
  dab_settings.pairs = c.choice<Pairs>("pairs");

  const auto region = region_of(c, picture, strokes, fill, s.extent);
  Nib nib(picture, learn(picture, region, s, c.work().quiet()), dab_settings);
  const double n = static_cast<double>(strokes.strokes.size()) + 1;
  for (std::size_t i = 0; i < strokes.strokes.size(); ++i)
    nib.paint(strokes.strokes[i], c.work().part(i / n, (i + 1) / n));
  if (!fill.empty()) nib.paint(pixels_of(fill), c.work().part(1 - 1 / n, 1));

  double painted = 0, relevant = 0;
  for (const auto o : nib.occupancy()) painted += o;
  for (const auto b : nib.base_relative()) relevant += b != kNoLevel;
  c.metric("painted_pixels", painted);
  c.metric("relevant_fraction", relevant / nib.base_relative().size());
  c.metric("threshold", nib.texture().threshold);
  c.metric("error", nib.error());
  c.output("base_relative", base_relative_view(nib));
  c.output("occupancy", occupancy_view(nib));
  c.output("image", nib.picture());
}

}  // namespace
}  // namespace terrazzo::texture_nib

namespace terrazzo {

NodeType texture_nib_node() {
  using namespace texture_nib;
  return NodeType("TextureNib", 2)
      .doc_(
          "Paints a region's texture along strokes so that it grows out of its surroundings. Also erases "
          "objects from textured pictures.")
      .source_(
          "Malzbender and Spach 1993, section 4; finish patches: completion after Wexler, Shechtman and "
          "Irani 2007 and Barnes et al. 2009")
      .input("image", "Image", "Picture with one section")
      .optional_input("strokes", {"Strokes"}, "Strokes to paint")
      .optional_input(
          "fill", {"Labels", "Image"},
          "Area to paint after the strokes: pixels with a label other than 0, or with a brightness over 0.2")
      .optional_input("region_mask", {"Labels", "Image"},
                      "Region whose texture is painted, instead of the parameter region")
      .output("image", "Image", "Painted picture")
      .output("base_relative", "Image",
              "Picture in the texture's levels, magenta where its colors are not in the texture")
      .output("occupancy", "Image", "White where the nib has painted")
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "region", "rest")
                     .count(4, 4096)
                     .range(-1e6, 1e6)
                     .unit_("pixels")
                     .doc_("Region whose texture is painted: x, y, width, height, or a polygon's corners, x "
                           "and y in turn. rest: all pixels that are not painted."))
      .parameter(Parameter::integer("levels", 8)
                     .range(2, kMostLevels)
                     .doc_("Number of colors of the texture, found by k-means"))
      .parameter(Parameter::choice("space", "oklab", {"oklab", "rgb"})
                     .doc_("Color space for comparison, with values from 0 to 1: Oklab, or display-encoded "
                           "RGB (as in the paper)"))
      .parameter(Parameter::integer("extent", 3)
                     .range(1, 16)
                     .unit_("pixels")
                     .doc_("Largest offset in x and y, in both directions. 3 is a kernel of 7 × 7 pixels."))
      .parameter(
          Parameter::integer("scales", 1)
              .range(1, 8)
              .doc_("Number of scales. Offsets are also used 2, 4, … times as long, up to 2^(scales − 1)."))
      .parameter(Parameter::optional_number("threshold", "auto")
                     .range(0, 10)
                     .doc_("Threshold φ in units of the color space: pixels whose color is farther than this "
                           "from all levels are ignored. auto: 1.25 times the distance that 99 % of the "
                           "region's pixels stay within."))
      .parameter(
          Parameter::integer("passes", 4)
              .range(1, 1000)
              .doc_("Visits per pixel of a dab. Every pixel is visited once before any is visited again."))
      .parameter(Parameter::choice("pairs", "touching", {"touching", "painted"})
                     .doc_("Pairs of pixels whose statistics are matched to the region's. touching: those "
                           "with at least one painted pixel, so that the texture continues its surroundings. "
                           "painted: those with two, as in the paper; the surroundings have no influence."))
      .parameter(Parameter::choice("finish", "patches", {"levels", "colors", "patches"})
                     .doc_("levels: the clustered colors, as in the paper. colors: colors of region pixels "
                           "with the same level and similar neighborhoods. patches: the region's pixels, "
                           "arranged from coarse to fine so that every patch looks like one of the region. "
                           "Shapes survive, and the levels are updated to match."))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
