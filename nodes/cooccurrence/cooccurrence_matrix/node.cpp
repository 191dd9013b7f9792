#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/cooccurrence/cooccurrence_matrix/matrix.h"
#include "runtime/context.h"

namespace terrazzo::cooccurrence_matrix {
namespace {

void measure_matrix(Context& c) {
  const Image& picture = c.input<Image>("image");
  if (picture.pixels.empty()) throw Error("empty-image", "the image has no pixels", "connect an image");
  std::vector<std::uint8_t> mask;
  if (c.has("mask")) mask = mask_of(c.value("mask"), picture, "mask");
  std::vector<Vec3f> pixels;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    if (mask.empty() || mask[i]) pixels.push_back(picture.pixels[i]);
  if (pixels.empty()) throw Error("no-pixels", "the mask excludes every pixel of the picture");
  const int wanted = c.integer("levels"), extent = c.integer("extent");
  const ColorLevels levels =
      color_levels(pixels, wanted, c.choice<ColorSpace>("space"), c.seed(), c.work().quiet());
  if (levels.count() < wanted)
    c.warn(fmt::format("the picture has only {} different colors; levels is {}", levels.count(), wanted));
  const int level = c.optional_integer("level").value_or(0);
  if (level > levels.count())
    throw Error("bad-value", fmt::format("the picture has {} levels; level is {}", levels.count(), level),
                "choose a smaller level")
        .parameter("level");
  std::vector<LevelField> sections;
  for (int s = 0; s < picture.sections; ++s)
    sections.push_back(levels_of(picture, s, levels, mask, c.work().quiet()));
  const Cooccurrence matrix = measure_cooccurrence(sections, levels.count(), all_offsets(extent), c.work());

  Image quantized(picture.width, picture.height, 1, picture.pixel_size);
  for (std::size_t i = 0; i < quantized.pixels.size(); ++i)
    if (sections[0].at[i] != kNoLevel) quantized.pixels[i] = levels.color[sections[0].at[i]];
  c.metric("levels", levels.count());
  c.output("table", matrix_table(matrix));
  c.output("figure", slice_figure(matrix, extent, level));
  c.output("quantized", std::move(quantized));
}

}  // namespace
}  // namespace terrazzo::cooccurrence_matrix

namespace terrazzo {

NodeType cooccurrence_matrix_node() {
  using namespace cooccurrence_matrix;
  return NodeType("CooccurrenceMatrix", 1)
      .doc_(
          "Measures the color co-occurrence matrix of a picture: how often two colors are found at an offset")
      .source_("Malzbender and Spach 1993, section 2 and figure 2")
      .input("image", "Image", "Texture; several sections are measured together")
      .optional_input(
          "mask", {"Labels", "Image"},
          "Where the texture is measured: pixels with a label other than 0, or with a brightness over 0.2")
      .output("table", "Table",
              "One row per offset and pair of levels: dx and dy (rows down) in pixels, home and remote level "
              "from 1, the number of pairs of pixels at that offset, and the share with these levels")
      .output(
          "figure", "Image",
          "Slices through the matrix for pairs of equal levels: along dy at dx = 0, and along dx at dy = 0")
      .output("quantized", "Image", "First section in the levels' colors; black outside the mask")
      .parameter(Parameter::integer("levels", 8)
                     .range(2, 16)
                     .doc_("Number of colors, found by k-means. Level 1 "
                           "has the smallest first component."))
      .parameter(Parameter::choice("space", "oklab", {"oklab", "rgb"})
                     .doc_("Color space for clustering: Oklab, or display-encoded RGB (as in the paper)"))
      .parameter(Parameter::integer("extent", 8)
                     .range(1, 16)
                     .unit_("pixels")
                     .doc_("Largest offset in x and y, in both directions"))
      .parameter(Parameter::optional_integer("level", "all")
                     .range(1, 16)
                     .doc_("Level of the curves in the figure; all: one curve per level"))
      .parameter(Parameter::seed())
      .compute_(measure_matrix);
}

}  // namespace terrazzo
