#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/bodies/contact_sheet/sheet.h"
#include "nodes/data/indices.h"
#include "runtime/context.h"

namespace terrazzo::contact_sheet {
namespace {

void compute(Context& c) {
  std::vector<Image> images;
  for (const Value& v : c.list("images")) {
    const Image image = v.is<Labels>() ? picture_of(v.as<Labels>()) : v.as<Image>();
    if (image.width <= 0 || image.height <= 0 || image.sections <= 0)
      throw Error("empty-image", fmt::format("image {} has no pixels", images.size() + 1));
    for (std::size_t i = 0; i < pixels_in(image.width, image.height); ++i)
      if (!image.pixels[i].allFinite())
        throw Error("bad-pixels", fmt::format("image {} has a non-finite pixel at ({}, {})",
                                              images.size() + 1, i % image.width, i / image.width));
    images.push_back(image);
  }
  if (images.empty()) throw Error("no-images", "no images are connected", "connect at least one to 'images'");
  SheetOptions choice;
  if (c.keyword("captions").empty()) choice.captions = c.texts("captions");
  if (choice.captions.size() > images.size())
    throw Error("too-many-captions", fmt::format("there are {} captions for {} images; remove some",
                                                 choice.captions.size(), images.size()))
        .parameter("captions");
  if (const auto v = c.optional_integer("columns")) choice.columns = *v;
  choice.cell = c.integer("cell");
  choice.background = c.choice<Background>("background");
  const Image sheet = contact_sheet::contact_sheet(images, choice, c.work());
  c.metric("pictures", images.size());
  c.output("image", sheet);
}

}  // namespace
}  // namespace terrazzo::contact_sheet

namespace terrazzo {

NodeType contact_sheet_node() {
  using namespace contact_sheet;
  return NodeType("ContactSheet", 1)
      .doc_(
          "Arranges images side by side with captions, as an overview of a run. A stack shows its first "
          "section.")
      .input_list("images", {"Image", "Labels"},
                  "Images in reading order. Labels get one color per profile on a dark binder")
      .output("image", "Image", "The contact sheet")
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "captions", "none")
                     .doc_("Captions in the order of the images. There may be fewer captions than images."))
      .parameter(Parameter::optional_integer("columns", "auto")
                     .range(1, 1000)
                     .doc_("Images per row. auto: up to three images share one row; more form a roughly "
                           "square sheet."))
      .parameter(Parameter::integer("cell", 480)
                     .unit_("pixels")
                     .range(32, 4096)
                     .doc_("Length of each image's longer side."))
      .parameter(Parameter::choice("background", "light", {"light", "dark"})
                     .doc_("Background color. light: white. dark: nearly black."))
      .compute_(compute);
}

}  // namespace terrazzo
