#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/contact_sheet/sheet.h"
#include "runtime/context.h"

namespace terrazzo {

namespace {

void compute(Context& c) {
  std::vector<Image> images;
  for (const Value& v : c.list("images")) {
    const Image image = v.is<Labels>() ? picture_of(v.as<Labels>()) : v.as<Image>();
    if (image.width <= 0 || image.height <= 0 || image.sections <= 0)
      throw Error("empty-image", fmt::format("picture {} has no pixels", images.size() + 1));
    for (std::size_t i = 0; i < static_cast<std::size_t>(image.width) * image.height; ++i)
      if (!image.pixels[i].allFinite())
        throw Error("bad-pixels", fmt::format("picture {} has a pixel that is not a number at ({}, {})",
                                              images.size() + 1, i % image.width, i / image.width));
    images.push_back(image);
  }
  if (images.empty()) throw Error("no-images", "there are no pictures", "connect at least one to images");
  SheetChoice choice;
  if (c.keyword("captions").empty()) choice.captions = c.texts("captions");
  if (choice.captions.size() > images.size())
    throw Error("too-many-captions",
                fmt::format("{} captions for {} pictures", choice.captions.size(), images.size()))
        .parameter("captions");
  if (c.keyword("columns").empty()) choice.columns = static_cast<int>(c.integer("columns"));
  choice.cell = static_cast<int>(c.integer("cell"));
  choice.dark = c.text("background") == "dark";
  const Image sheet = contact_sheet(images, choice, c.work());
  c.metric("pictures", static_cast<double>(images.size()));
  c.output("image", sheet);
}

}  // namespace

NodeType contact_sheet_node() {
  return NodeType("ContactSheet", 1)
      .doc_(
          "Pictures side by side with captions, to look at a whole run at once. Of stacks, the first "
          "section.")
      .input_list("images", {"Image", "Labels"},
                  "pictures in reading order; labels get a colour per profile on dark binder")
      .output("image", "Image", "the sheet")
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "captions", "none")
                     .doc_("Words below the pictures, in their order; may be fewer."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Int, "columns", "auto")
              .range(1, 1000)
              .doc_("Pictures in a row; auto: up to three in one row, else about as many columns as rows."))
      .parameter(Parameter::integer("cell", 480)
                     .unit_("pixels")
                     .range(32, 4096)
                     .doc_("Length of each picture's longer side."))
      .parameter(Parameter::choice("background", "light", {"light", "dark"}).doc_("White, or nearly black."))
      .compute_(compute);
}

}  // namespace terrazzo
